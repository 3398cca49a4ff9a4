// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/health/health_state.hpp"

// The messages of grpc.health.v1 as bytes, which gRPC does not parse before our code has seen their size.
namespace segserve::server {

/// The name of the service that a HealthCheckRequest asks for. Empties the buffer. INVALID_ARGUMENT.
absl::StatusOr<std::string> service_of(grpc::ByteBuffer& request);

/// A HealthCheckResponse.
grpc::ByteBuffer health_response(HealthState::Status status);

}  // namespace segserve::server
