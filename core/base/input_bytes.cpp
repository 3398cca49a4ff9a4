// SPDX-License-Identifier: Apache-2.0
#include "core/base/input_bytes.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/status_macros.hpp"

namespace segserve {
namespace {

/// Closes a file descriptor, but not one that was there before.
class Descriptor {
 public:
  Descriptor(int number, bool is_own) : number_(number), is_own_(is_own) {}
  Descriptor(Descriptor&& other) noexcept : number_(other.number_), is_own_(std::exchange(other.is_own_, false)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (is_own_) close(number_);
  }
  int number() const { return number_; }

 private:
  const int number_;
  bool is_own_;
};

/// The descriptor of this process that a path names.
std::optional<int> descriptor_of(std::string_view path) {
  if (path == "-" || path == "/dev/stdin") return STDIN_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    const std::string_view digits = path.substr(folder.size());
    int number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error == std::errc{} && end == digits.data() + digits.size() && number >= 0) return number;
  }
  return std::nullopt;
}

absl::Status failed(int error) {
  const char* const why = std::strerror(error);
  if (error == ENOENT || error == ENOTDIR) return absl::NotFoundError(why);
  return error == EACCES ? absl::PermissionDeniedError(why) : absl::UnavailableError(why);
}

/// INVALID_ARGUMENT for what reading would wait for, or never come to the end of.
absl::Status check_kind(mode_t mode) {
  if (S_ISDIR(mode)) return absl::InvalidArgumentError("it is a folder");
  if (S_ISCHR(mode)) return absl::InvalidArgumentError("it is a character device, and no file");
  if (S_ISBLK(mode)) return absl::InvalidArgumentError("it is a block device, and no file");
  if (S_ISSOCK(mode)) return absl::InvalidArgumentError("it is a socket, and no file");
  return absl::OkStatus();
}

absl::StatusOr<Descriptor> open_input(const std::string& path) {
  struct stat state {};
  if (const auto number = descriptor_of(path)) {
    if (fstat(*number, &state) != 0) return failed(errno);
    if (S_ISDIR(state.st_mode)) return check_kind(state.st_mode);
    return Descriptor(*number, false);
  }
  if (stat(path.c_str(), &state) != 0) return failed(errno);
  RETURN_IF_ERROR(check_kind(state.st_mode));  // before it is opened, which alone may do something to a device
  // To open a pipe that has no writer would wait for one.
  const int number = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (number < 0) return failed(errno);
  Descriptor opened(number, true);
  if (fstat(number, &state) != 0) return failed(errno);
  RETURN_IF_ERROR(check_kind(state.st_mode));  // it may have been replaced meanwhile
  return opened;
}

/// Waits until there is something to read, or the end.
absl::Status wait_for_bytes(int number, const StopToken& stop) {
  constexpr int kMilliseconds = 100;
  while (true) {
    RETURN_IF_ERROR(stop.check());
    pollfd waiting{.fd = number, .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, kMilliseconds);
    if (ready > 0) return absl::OkStatus();
    if (ready < 0 && errno != EINTR) return failed(errno);
  }
}

}  // namespace

absl::StatusOr<std::string> read_input_bytes(const std::string& path, std::uint64_t most_bytes, const StopToken& stop) {
  constexpr std::uint64_t kPart = std::uint64_t{1} << 20U;
  ASSIGN_OR_RETURN(const Descriptor input, open_input(path));
  std::string bytes;
  std::size_t size = 0;
  while (size <= most_bytes) {
    RETURN_IF_ERROR(wait_for_bytes(input.number(), stop));
    const auto part = static_cast<std::size_t>(std::min(kPart, most_bytes - size + 1));
    if (bytes.size() < size + part) bytes.resize(std::max(size + part, size + size / 2));
    const ssize_t count = read(input.number(), bytes.data() + size, part);
    if (count == 0) break;
    if (count < 0 && errno != EINTR && errno != EAGAIN) return failed(errno);
    size += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace segserve
