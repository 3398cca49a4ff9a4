// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/refusals.hpp"

#include <string>
#include <string_view>

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

/// Returns the name of the field of v1.Limits.
std::string_view limit_name(Refusal::Bound bound) {
  switch (bound) {
    case Refusal::Bound::kJobs:
      return "max_queue";
    case Refusal::Bound::kBytes:
      return "max_queue_bytes";
    case Refusal::Bound::kPoints:
      return "max_queue_points";
  }
  return "";
}

}  // namespace

absl::Status queue_full(const Refusal& refusal, std::chrono::milliseconds retry_delay) {
  const std::string_view limit = limit_name(refusal.bound);
  return wire::with_details(
      absl::ResourceExhaustedError(fmt::format("the queue is full: {} is {}, this would make it {}; try again later",
                                               limit, refusal.allowed, refusal.actual)),
      {.reason = wire::ErrorReason::kQueueFull,
       .metadata = {{"limit", std::string(limit)},
                    {"allowed", fmt::format("{}", refusal.allowed)},
                    {"actual", fmt::format("{}", refusal.actual)}},
       .retry_delay = retry_delay});
}

absl::Status evicted_from_queue(std::chrono::milliseconds retry_delay) {
  return wire::with_details(
      absl::ResourceExhaustedError(
          "the queue is full, and this client has the most in it, so this call made way for another "
          "client; try again later"),
      {.reason = wire::ErrorReason::kQueueFull, .retry_delay = retry_delay});
}

absl::Status draining() {
  constexpr std::chrono::milliseconds kRetryElsewhere{500};
  return wire::with_details(absl::UnavailableError("the server is about to stop; try again with another replica"),
                            {.reason = wire::ErrorReason::kDraining, .retry_delay = kRetryElsewhere});
}

}  // namespace segserve::server
