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

bool tells_of_no_connection(const std::string& message) {
  return message.starts_with("connections to all backends failing") ||
         message.starts_with("failed to connect to all addresses");
}

/// The cause of a failed connection alone, without the names of gRPC's parts around it: "connections to all backends
/// failing; last error: UNKNOWN: ipv4:127.0.0.1:1: Failed to connect to remote host: Connection refused" is
/// "Connection refused".
std::string cause_of(const std::string& message) {
  const bool is_wordy = tells_of_no_connection(message) || message.starts_with("DNS resolution failed");
  const std::size_t colon = message.rfind(": ");
  return is_wordy && colon != std::string::npos ? message.substr(colon + 2) : message;
}

}  // namespace

absl::Status call_status(const grpc::Status& grpc_status, std::string_view address) {
  const absl::Status status = wire::from_grpc(grpc_status);
  const wire::ErrorDetails details = wire::details_of(status);
  std::string message(status.message());
  if (is_connection_error(status, details)) {
    message = fmt::format("no answer from {}: {}", address, cause_of(message));
    if (absl::IsUnavailable(status)) message += "; is segserve running there?";
  }
  const bool is_unknown_method = absl::IsUnimplemented(status) && message.empty();
  if (is_unknown_method)
    message = fmt::format("the server at {} does not offer this; does it answer probes only?", address);
  for (const FieldViolation& fault : details.fields) {
    if (message.find(fault.field) == std::string::npos) {
      message += fmt::format("; {}: {}", fault.field, fault.description);
    }
  }
  if (details.retry_delay) message += fmt::format(" (try again in {} ms)", details.retry_delay->count());
  return wire::with_details(absl::Status(status.code(), message), details);
}

bool handshake_failed(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNAVAILABLE && tells_of_no_connection(status.error_message()) &&
         status.error_message().find("Failed to connect to remote host") == std::string::npos;
}

}  // namespace segserve::client
