// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "segserve/options.hpp"
#include "segserve/v1/error_reason.pb.h"

namespace segserve::wire {

using v1::ErrorReason;

/// Says of an error what its code and message do not.
struct ErrorDetails {
  ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;  ///< UNSPECIFIED also for reasons newer than this program
  std::map<std::string, std::string> metadata = {};   ///< e.g. limit, allowed, actual
  std::vector<FieldViolation> fields = {};            ///< every wrong field by its path in the request
  std::optional<std::chrono::milliseconds> retry_delay = std::nullopt;  ///< try again, not before this time has passed
};

/// The details that a status of the client library carries; empty details if it carries none.
ErrorDetails details_of(const absl::Status& status);

}  // namespace segserve::wire
