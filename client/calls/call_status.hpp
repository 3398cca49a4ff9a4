#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace segserve::client {

/// The error of a call as a status that people can read: every wrong field is named in the message,
/// a wait that the server asks for too, and an error of the connection says to whom.
absl::Status call_status(const grpc::Status& status, std::string_view address);

}  // namespace segserve::client
