// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "server/scheduling/fair_queue.hpp"

// The server's answers to calls and frames that it does not take although nothing is wrong with them. Each of these
// says when to try again.
namespace segserve::server {

/// RESOURCE_EXHAUSTED, QUEUE_FULL, for a job that the pool refused. Names the limit.
absl::Status queue_full(const Refusal& refusal, std::chrono::milliseconds retry_delay);

/// RESOURCE_EXHAUSTED, QUEUE_FULL, for a job that was evicted.
absl::Status evicted_from_queue(std::chrono::milliseconds retry_delay);

/// UNAVAILABLE, DRAINING, for calls and frames that come when the server is about to stop.
absl::Status draining();

}  // namespace segserve::server
