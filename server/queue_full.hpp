#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "server/fair_queue.hpp"

namespace segserve::server {

/// RESOURCE_EXHAUSTED, QUEUE_FULL, for a job that the pool refused: names the limit, and when to try again.
absl::Status queue_full(const Refusal& refusal, std::chrono::milliseconds retry_delay);

/// The same for a job that was evicted.
absl::Status evicted_from_queue(std::chrono::milliseconds retry_delay);

}  // namespace segserve::server
