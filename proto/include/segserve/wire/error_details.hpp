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
  kTokenMissing,
  kTokenInvalid,
  kTokenExpired,
  kQuotaExceeded,
};

/// The name of a reason as google.rpc.ErrorInfo writes it, e.g. "QUEUE_FULL".
std::string_view name(ErrorReason reason);

/// A quota that stands in the way.
struct QuotaViolation {
  std::string subject;      ///< whose quota, e.g. "subject:robot-7"
  std::string description;  ///< which one, for people
};

/// The details of an error beyond its code and message, for programs.
struct ErrorDetails {
  ErrorReason reason = ErrorReason::kUnspecified;
  /// Further facts by name. kLimitExceeded and kQueueFull have "limit", "allowed" and "actual", kQuotaExceeded
  /// has "limit" and "allowed".
  std::map<std::string, std::string> metadata = {};
  /// Every wrong field of the request, by its path, e.g. "options.lambda". kInvalidField has at least one.
  std::vector<FieldViolation> fields = {};
  /// The quotas of kQuotaExceeded, at least one.
  std::vector<QuotaViolation> quotas = {};
  /// How long to wait before the next attempt, from 0 to one day. It is unset unless the server suggests a delay.
  std::optional<std::chrono::milliseconds> retry_delay = std::nullopt;
};

/// The details that a status of the client library carries. A status without details gives kUnspecified and nothing
/// else.
ErrorDetails details_of(const absl::Status& status);

}  // namespace segserve::wire
