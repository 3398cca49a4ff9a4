// SPDX-License-Identifier: Apache-2.0
#include "segserve/client/stream_options.hpp"

#include <utility>

#include "fmt/format.h"

namespace segserve::client {

std::vector<FieldViolation> violations(const StreamOptions& options) {
  constexpr std::int64_t kMostFrames = 1024;
  constexpr std::int64_t kMostServers = 64;
  constexpr std::int64_t kDay = 86'400'000;
  std::vector<FieldViolation> faults = segserve::violations(options.options);
  const auto in_range = [&faults](const char* name, std::int64_t value, std::int64_t minimum, std::int64_t maximum) {
    if (value < minimum || value > maximum) {
      faults.push_back({name, fmt::format("{} is not in [{}, {}]", value, minimum, maximum)});
    }
  };
  if (options.tracking) {
    for (FieldViolation& fault : segserve::violations(*options.tracking)) {
      faults.push_back({fmt::format("tracking.{}", fault.field), std::move(fault.description)});
    }
  }
  in_range("max_in_flight", static_cast<std::int64_t>(options.max_in_flight), 1, kMostFrames);
  in_range("max_waiting", static_cast<std::int64_t>(options.max_waiting), 1, kMostFrames);
  in_range("max_servers", static_cast<std::int64_t>(options.max_servers), 1, kMostServers);
  in_range("hedge_after", options.hedge_after.count(), 0, kDay);
  in_range("frame_timeout", options.frame_timeout.count(), 1, kDay);
  in_range("progress_timeout", options.progress_timeout.count(), 2, kDay);
  in_range("longest_outage", options.longest_outage.count(), 0, kDay);
  in_range("retry.max_attempts", options.retry.max_attempts, 1, 1'000'000);
  in_range("retry.first_backoff", options.retry.first_backoff.count(), 1, kDay);
  in_range("retry.max_backoff", options.retry.max_backoff.count(), options.retry.first_backoff.count(), kDay);
  return faults;
}

}  // namespace segserve::client
