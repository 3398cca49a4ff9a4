// SPDX-License-Identifier: Apache-2.0
#include "server/options/server_options.hpp"

#include <algorithm>
#include <utility>

#include "absl/status/statusor.h"
#include "fmt/format.h"
#include "proto/wire/transport_limits.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {
namespace {

template <typename Value>
void check_range(const char* flag, Value value, Value minimum, Value maximum, std::vector<FieldViolation>& faults) {
  if (value < minimum || value > maximum) {
    faults.push_back({flag, fmt::format("{} is not in [{}, {}]", value, minimum, maximum)});
  }
}

void check_listen(const ServerOptions& options, std::vector<FieldViolation>& faults) {
  const absl::StatusOr<ListenAddress> address = parse_listen_address(options.listen);
  if (!address.ok()) {
    faults.push_back({"listen", std::string(address.status().message())});
  } else if (!address->is_loopback() && !options.insecure_beyond_loopback) {
    faults.push_back({"listen", fmt::format("{} can be reached by other machines, and the connection is not encrypted; "
                                            "--insecure-beyond-loopback allows that",
                                            options.listen)});
  }
}

}  // namespace

std::vector<FieldViolation> violations(const ServerOptions& options) {
  constexpr std::uint64_t kPetabyte = std::uint64_t{1} << 50U, kTerabyte = std::uint64_t{1} << 40U;
  constexpr std::uint64_t kLeastMemory = std::uint64_t{64} << 20U;
  constexpr std::int64_t kDayMs = 86'400'000;
  std::vector<FieldViolation> faults;
  check_listen(options, faults);
  check_range<std::size_t>("workers", options.workers, 0, 1024, faults);
  check_range<std::uint32_t>("threads", options.threads, 1, 64, faults);
  check_range<std::size_t>("queue", options.queue, 1, 100'000, faults);
  check_range<std::uint64_t>("queue-bytes", options.queue_bytes,
                             std::max(options.max_decoded_bytes, wire::kMaxRequestBytes), kPetabyte, faults);
  check_range<std::uint64_t>("queue-points", options.queue_points, options.max_points, kPetabyte, faults);
  check_range<std::uint32_t>("stream-frames", options.stream_frames, 1, 1024, faults);
  check_range<std::uint64_t>("stream-bytes", options.stream_bytes, 1, kTerabyte, faults);
  check_range<std::uint64_t>("max-points", options.max_points, 1, 1'000'000'000, faults);
  check_range<std::uint64_t>("max-decoded-bytes", options.max_decoded_bytes, 1, kTerabyte, faults);
  check_range<std::uint64_t>("max-voxels", options.max_voxels, 1, 1'000'000'000, faults);
  if (options.memory != 0) check_range<std::uint64_t>("memory", options.memory, kLeastMemory, kPetabyte, faults);
  check_range<std::int64_t>("max-frame-seconds", options.max_frame_time.count(), 1, kDayMs, faults);
  check_range<std::int64_t>("grace-period", options.grace_period.count(), 0, kDayMs, faults);
  check_range<std::int64_t>("drain-delay", options.drain_delay.count(), 0, kDayMs, faults);
  for (FieldViolation& fault : segserve::violations(options.defaults)) faults.push_back(std::move(fault));
  return faults;
}

}  // namespace segserve::server
