// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/staged_output.hpp"
#include "nlohmann/json_fwd.hpp"

namespace segserve::segctl {

/// The JSON text in one line that ends with a line feed, or indented by `indent` spaces. JSON must be UTF-8, but file
/// names need not be: other bytes are replaced.
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

/// The flag --json: a file, or "-" for standard output. It must outlive the parsing of the command line.
class JsonFlag {
 public:
  void add_to(CLI::App& app, const std::string& help);

  bool given() const { return !path_.empty(); }

  /// Announces the file (StagedOutput::announce) if the flag was given.
  absl::Status announce(StagedOutput& output) const;

  /// Adds the content of the file if the flag was given.
  void add(StagedOutput& output, std::string text) const;
  void add(StagedOutput& output, const nlohmann::ordered_json& json) const;

 private:
  std::string path_;
};

}  // namespace segserve::segctl
