#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace segserve::server {

/// INVALID_ARGUMENT, PROTOCOL_VIOLATION: what the client sent is against the rules of stream.proto, and ends the
/// stream.
absl::Status protocol_violation(std::string_view what);

}  // namespace segserve::server
