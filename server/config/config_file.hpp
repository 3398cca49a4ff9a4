// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace segserve::server {

/// A key of a file and its value, which an option reads as text.
struct FileEntry {
  std::string name;
  std::vector<std::string> values;  ///< more than one for an array
  bool is_boolean = false;          ///< `values` holds "true" or "false"
  std::size_t line = 0;             ///< counted from 1
};

/// A fault in a line; line 0 stands for the file as a whole.
struct FileFault {
  std::size_t line = 0;
  std::string what;
};

struct ConfigFile {
  std::vector<FileEntry> entries;
  std::vector<FileFault> faults;
};

/// Reads TOML whose keys stand at the top, without tables. Every faulty line is reported, not only the first one.
ConfigFile parse_config(std::string text);

/// Reads a file in the same way. A file that cannot be read, or has more than 1 MiB, is a fault.
ConfigFile read_config_file(const std::string& path);

}  // namespace segserve::server
