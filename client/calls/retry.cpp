// SPDX-License-Identifier: Apache-2.0
#include "client/calls/retry.hpp"

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

}  // namespace segserve::client
