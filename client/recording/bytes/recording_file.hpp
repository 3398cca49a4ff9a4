// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace segserve::recording {

/// A file of which parts are read, one after the other.
class RecordingFile {
 public:
  /// NOT_FOUND or UNAVAILABLE if the file cannot be opened; INVALID_ARGUMENT for what is no regular file: a recording
  /// is read in parts, and twice. Messages name the path.
  static absl::StatusOr<RecordingFile> open(const std::string& path);

  std::uint64_t size() const { return size_; }
  std::uint64_t offset() const { return offset_; }
  std::uint64_t left() const { return size_ - offset_; }

  /// Reads `count` bytes, which must be at most left(). UNAVAILABLE if reading fails.
  absl::Status read(std::uint64_t count, std::string& out);
  /// Goes to a byte, which must be at most size().
  absl::Status seek(std::uint64_t offset);

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::uint64_t size_ = 0;
  std::uint64_t offset_ = 0;
};

}  // namespace segserve::recording
