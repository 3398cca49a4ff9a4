// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/retry.hpp"

#include <algorithm>

#include "proto/wire/status_message.hpp"

namespace segserve::client {

bool is_retryable(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kResourceExhausted:  // A frame beyond a limit never fits.
      return wire::details_of(status).reason != wire::ErrorReason::kLimitExceeded;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kCancelled:
      return true;
    case absl::StatusCode::kDeadlineExceeded:
      return wire::details_of(status).reason == wire::ErrorReason::kUploadStalled;
    default:
      return false;
  }
}

bool is_worth_reconnecting(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kPermissionDenied:
      return false;
    default:
      return true;
  }
}

absl::Status unavailable_if_cancelled(const absl::Status& status) {
  if (!absl::IsCancelled(status)) return status;
  return absl::UnavailableError("the server ended the call");
}

std::chrono::milliseconds backoff(const RetryOptions& retry, std::uint32_t attempt,
                                  std::optional<std::chrono::milliseconds> asked_for, std::minstd_rand& random) {
  constexpr std::uint32_t kMostDoublings = 20;
  const std::uint32_t doublings = std::min(std::max(attempt, 1U) - 1, kMostDoublings);
  const double full = std::min(static_cast<double>(retry.first_backoff.count()) * static_cast<double>(1U << doublings),
                               static_cast<double>(retry.max_backoff.count()));
  const double share = std::uniform_real_distribution<double>(0.5, 1.0)(random);
  const auto wait = std::chrono::milliseconds(static_cast<std::int64_t>(full * share));
  return std::max(wait, asked_for.value_or(wait));
}

}  // namespace segserve::client
