// SPDX-License-Identifier: Apache-2.0
#include "server/stream/protocol_violation.hpp"

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::server {

absl::Status protocol_violation(std::string_view what) {
  return wire::with_reason(absl::InvalidArgumentError(fmt::format("protocol of the stream: {}", what)),
                           wire::ErrorReason::kProtocolViolation);
}

}  // namespace segserve::server
