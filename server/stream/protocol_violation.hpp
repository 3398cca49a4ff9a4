// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace segserve::server {

/// INVALID_ARGUMENT, PROTOCOL_VIOLATION: the client broke the rules of stream.proto, which ends the stream.
absl::Status protocol_violation(std::string_view what);

}  // namespace segserve::server
