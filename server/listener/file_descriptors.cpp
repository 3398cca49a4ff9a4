// SPDX-License-Identifier: Apache-2.0
#include "server/listener/file_descriptors.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

namespace segserve::server {

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
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const std::uint64_t fit = limit.rlim_cur / kShare / descriptors_of_connection;
  return std::clamp<std::uint64_t>(fit, 1, most);
}

void raise_file_descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace segserve::server
