// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/input_file.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "fmt/format.h"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::segctl {
namespace {

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

absl::Status cannot_open(const std::string& path, int error) {
  const std::string message = fmt::format("cannot read {}: {}", path, std::strerror(error));
  return error == ENOENT || error == ENOTDIR ? absl::NotFoundError(message) : absl::UnavailableError(message);
}

absl::StatusOr<std::string> read_all(std::FILE* file, const std::string& path) {
  constexpr std::uint64_t kMaxBytes = codec::DecodeLimits{}.max_bytes;
  std::string bytes;
  std::array<char, 1U << 16U> part{};
  for (std::size_t count = 0; (count = std::fread(part.data(), 1, part.size(), file)) > 0;) {
    bytes.append(part.data(), count);
    if (bytes.size() > kMaxBytes) {
      return absl::InvalidArgumentError(
          fmt::format("{} is larger than the {} bytes that are allowed", input_name(path), kMaxBytes));
    }
  }
  if (std::ferror(file) != 0) {
    return absl::UnavailableError(fmt::format("cannot read {}: {}", input_name(path), std::strerror(errno)));
  }
  return bytes;
}

}  // namespace

std::string input_name(const std::string& path) { return path == "-" ? "standard input" : path; }

absl::StatusOr<std::string> read_input(const std::string& path) {
  if (path == "-") return read_all(stdin, path);
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return absl::InvalidArgumentError(fmt::format("cannot read {}: it is a folder", path));
  }
  const std::unique_ptr<std::FILE, Closer> file(std::fopen(path.c_str(), "rb"));
  if (file == nullptr) return cannot_open(path, errno);
  return read_all(file.get(), path);
}

}  // namespace segserve::segctl
