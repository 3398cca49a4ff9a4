// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "server/http/http_message.hpp"

namespace segserve::server {

/// The name that the protocol Connect gives to a code, such as "invalid_argument".
std::string_view connect_code(absl::StatusCode code);

/// The status of HTTP for a code, as Connect has it.
unsigned http_status(const absl::Status& status);

/// An error as JSON for people and small programs: {"error": {code, reason, message, fields, metadata,
/// retry_after_ms}}, of which the last three may be absent. It has Retry-After if the server suggests a delay. A body
/// beyond the limit has the status 413.
HttpAnswer error_answer(const absl::Status& status);

/// The answer to a request that breaks the rules of HTTP: an error_answer with this status, after which the connection
/// ends.
HttpAnswer http_fault_answer(unsigned status, std::string_view message);

/// An error as the protocol Connect has it: an object with code, message and details.
HttpAnswer connect_error_answer(const absl::Status& status);

}  // namespace segserve::server
