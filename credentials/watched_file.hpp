// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "absl/status/statusor.h"

namespace segserve::credentials {

/// A file that may change while the program runs: it is written anew, replaced, or reached by a symbolic link that
/// turns to another file, as Kubernetes does. Only its content counts, because times of files are too coarse to tell
/// every change. Not thread-safe.
class WatchedFile {
 public:
  using Content = absl::StatusOr<std::string>;

  WatchedFile(std::string path, std::size_t most_bytes) : path_(std::move(path)), most_bytes_(most_bytes) {}

  const std::string& path() const { return path_; }

  /// Reads the file. Later calls of `changed` compare with what this returned.
  Content read();

  /// The content, or why it cannot be read, if that is new since the last call that returned something, and was the
  /// same when the last call looked. So a file that is being written is not taken before it is whole.
  std::optional<Content> changed();

 private:
  const std::string path_;
  const std::size_t most_bytes_;
  Content in_use_;
  Content last_seen_;
};

}  // namespace segserve::credentials
