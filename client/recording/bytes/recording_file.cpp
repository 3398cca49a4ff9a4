// SPDX-License-Identifier: Apache-2.0
#include "client/recording/bytes/recording_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

namespace segserve::recording {

absl::StatusOr<RecordingFile> RecordingFile::open(const std::string& path) {
  constexpr const char* kNeedsFile = "a recording must be a regular file, because it is read twice";
  // To open a pipe would wait for whoever writes into it.
  if (struct stat state{}; stat(path.c_str(), &state) == 0 && !S_ISREG(state.st_mode)) {
    return absl::InvalidArgumentError(fmt::format("cannot read {}: {}", path, kNeedsFile));
  }
  RecordingFile file;
  file.path_ = path;
  file.file_.reset(std::fopen(path.c_str(), "rb"));
  struct stat status {};
  if (file.file_ == nullptr || fstat(fileno(file.file_.get()), &status) != 0) {
    const std::string message = fmt::format("cannot read {}: {}", path, std::strerror(errno));
    return errno == ENOENT || errno == ENOTDIR ? absl::NotFoundError(message) : absl::UnavailableError(message);
  }
  if (!S_ISREG(status.st_mode)) {
    return absl::InvalidArgumentError(fmt::format("cannot read {}: {}", path, kNeedsFile));
  }
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  return file;
}

absl::Status RecordingFile::read(std::uint64_t count, std::string& out) {
  out.resize(static_cast<std::size_t>(count));
  if (std::fread(out.data(), 1, out.size(), file_.get()) != out.size()) {
    const bool failed = std::ferror(file_.get()) != 0;
    return absl::UnavailableError(
        fmt::format("cannot read {}: {}", path_, failed ? std::strerror(errno) : "it has become shorter"));
  }
  offset_ += count;
  return absl::OkStatus();
}

absl::Status RecordingFile::seek(std::uint64_t offset) {
  if (fseeko(file_.get(), static_cast<off_t>(offset), SEEK_SET) != 0) {
    return absl::UnavailableError(fmt::format("cannot read {}: {}", path_, std::strerror(errno)));
  }
  offset_ = offset;
  return absl::OkStatus();
}

}  // namespace segserve::recording
