// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "grpcpp/support/byte_buffer.h"

namespace segserve::server {

/// Answers a ServerReflectionRequest with a ServerReflectionResponse, both as bytes: the messages of v1 and v1alpha
/// have the same. Tells of the services that this server has, and of the files that they need, and of no others.
/// Empties the request. INVALID_ARGUMENT if it cannot be parsed.
absl::StatusOr<grpc::ByteBuffer> answer_reflection(grpc::ByteBuffer& request);

}  // namespace segserve::server
