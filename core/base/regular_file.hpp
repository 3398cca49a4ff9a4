// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>

#include "absl/status/statusor.h"
#include "fmt/format.h"

namespace segserve {

/// The whole content of a regular file, or of one that symbolic links lead to. NOT_FOUND if it cannot be read, or is a
/// folder, a pipe or a device, whose reading could take for ever; INVALID_ARGUMENT if it has more than `most_bytes`.
/// The message names the file.
inline absl::StatusOr<std::string> read_regular_file(const std::string& path, std::size_t most_bytes) {
  const auto unreadable = [&path](const char* why) {
    return absl::NotFoundError(fmt::format("cannot read {}: {}", path, why));
  };
  // Opening a pipe would wait for whoever writes into it.
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return unreadable(std::strerror(errno));
  struct Closer {
    const int file;
    ~Closer() { close(file); }
  } const closer{file};
  struct stat state {};
  if (fstat(file, &state) != 0) return unreadable(std::strerror(errno));
  if (!S_ISREG(state.st_mode)) return unreadable("it is no regular file");
  std::string content;
  // One byte more tells whether the file is too large.
  while (content.size() <= most_bytes) {
    constexpr std::size_t kPart = 16384;
    const std::size_t before = content.size();
    content.resize(before + std::min(kPart, most_bytes + 1 - before));
    const ssize_t count = read(file, content.data() + before, content.size() - before);
    content.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count == 0) return content;
    if (count < 0 && errno != EINTR) return unreadable(std::strerror(errno));
  }
  return absl::InvalidArgumentError(fmt::format("{} has more than {} bytes", path, most_bytes));
}

}  // namespace segserve
