// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "segserve/options.hpp"

namespace segserve::wire {

/// Why a call or frame failed. The comments of segserve/v1/error_reason.proto describe each reason.
enum class ErrorReason : std::uint8_t {
  kUnspecified,  ///< the server gave no reason, or one that is newer than this program
  kInvalidField,
  kMalformedPayload,
  kInvalidCloud,
  kLimitExceeded,
  kQueueFull,
  kDraining,
  kDeadlineExceeded,
  kCancelled,
  kInternal,
  kChecksum,
  kUploadStalled,
  kProtocolViolation,
};

/// The name of a reason as it stands in google.rpc.ErrorInfo: "QUEUE_FULL".
std::string_view name(ErrorReason reason);

/// Says of an error what its code and message do not.
struct ErrorDetails {
  ErrorReason reason = ErrorReason::kUnspecified;
  std::map<std::string, std::string> metadata = {};  ///< e.g. limit, allowed, actual
  std::vector<FieldViolation> fields = {};           ///< every wrong field by its path in the request
  std::optional<std::chrono::milliseconds> retry_delay = std::nullopt;  ///< try again, not before this time has passed
};

/// The details that a status of the client library carries; empty details if it carries none.
ErrorDetails details_of(const absl::Status& status);

}  // namespace segserve::wire
