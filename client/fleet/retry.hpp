// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

#include "absl/status/status.h"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// Whether another try may succeed: after UNAVAILABLE, RESOURCE_EXHAUSTED, ABORTED (a checksum differed), CANCELLED,
/// and an upload that stalled. CANCELLED counts because servers that shut down end calls so; do not ask if the caller
/// cancelled.
bool is_retryable(const absl::Status& status);

/// Whether a stream that ended with this status may do better on another connection. False for errors that every server
/// would repeat.
bool is_worth_reconnecting(const absl::Status& status);

/// Replaces CANCELLED, with which servers that shut down end calls, by UNAVAILABLE. For calls that this client did not
/// cancel.
absl::Status unavailable_if_cancelled(const absl::Status& status);

/// The random time to wait before the `attempt`-th repetition, counted from 1: see RetryOptions. `asked_for` is the
/// time that the server asked for.
std::chrono::milliseconds backoff(const RetryOptions& retry, std::uint32_t attempt,
                                  std::optional<std::chrono::milliseconds> asked_for, std::minstd_rand& random);

}  // namespace segserve::client
