// SPDX-License-Identifier: Apache-2.0
#include "client/calls/call_status.hpp"

#include <string>

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::client {
namespace {

/// Whether gRPC made the error because no server answered.
bool is_connection_error(const absl::Status& status, const wire::ErrorDetails& details) {
  const bool candidate = absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status);
  return candidate && details.reason == wire::ErrorReason::kUnspecified;
}

}  // namespace

absl::Status call_status(const grpc::Status& grpc_status, std::string_view address) {
  const absl::Status status = wire::from_grpc(grpc_status);
  const wire::ErrorDetails details = wire::details_of(status);
  std::string message(status.message());
  if (is_connection_error(status, details)) message = fmt::format("no answer from {}: {}", address, message);
  for (const FieldViolation& fault : details.fields) {
    if (message.find(fault.field) == std::string::npos) {
      message += fmt::format("; {}: {}", fault.field, fault.description);
    }
  }
  if (details.retry_delay) message += fmt::format(" (try again in {} ms)", details.retry_delay->count());
  return wire::with_details(absl::Status(status.code(), message), details);
}

}  // namespace segserve::client
