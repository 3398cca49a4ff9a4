// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace segserve::client {

/// The error of a call as a status whose message people can read: it names every wrong field, the time to wait if the
/// server asked for that, and `address` if the connection failed.
absl::Status call_status(const grpc::Status& status, std::string_view address);

/// Whether a call failed because the server took the connection by TCP, but did not understand it, or was not trusted.
bool handshake_failed(const grpc::Status& status);

}  // namespace segserve::client
