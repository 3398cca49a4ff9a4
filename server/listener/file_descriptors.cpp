// SPDX-License-Identifier: Apache-2.0
#include "server/listener/file_descriptors.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

namespace segserve::server {
namespace {

/// As many connections as the part 1 / `share` of the limit holds, but at least one and not more than `most`.
std::size_t connections_of_share(std::uint64_t share, std::size_t most, std::size_t descriptors_of_connection) {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const std::uint64_t fit = limit.rlim_cur / share / descriptors_of_connection;
  return std::clamp<std::uint64_t>(fit, 1, most);
}

}  // namespace

FileDescriptors file_descriptors() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  std::error_code error;
  const std::filesystem::directory_iterator files("/proc/self/fd", error);
  if (error) return {.open = limit.rlim_cur, .limit = limit.rlim_cur};  // none is left even for that
  return {.open = static_cast<std::uint64_t>(std::distance(begin(files), end(files))), .limit = limit.rlim_cur};
}

std::size_t connections_beside_grpc(std::size_t most, std::size_t descriptors_of_connection) {
  constexpr std::uint64_t kShare = 4;
  return connections_of_share(kShare, most, descriptors_of_connection);
}

std::size_t connections_of_grpc(std::size_t most, std::size_t descriptors_of_connection) {
  constexpr std::uint64_t kShare = 2;
  return connections_of_share(kShare, most, descriptors_of_connection);
}

void raise_file_descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace segserve::server
