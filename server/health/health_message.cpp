// SPDX-License-Identifier: Apache-2.0
#include "server/health/health_message.hpp"

#include <cstddef>

#include "core/base/status_macros.hpp"
#include "grpcpp/support/slice.h"
#include "proto/wire/message_shape.hpp"

namespace segserve::server {
namespace {

constexpr std::size_t kMostHealthBytes = 1024;

}  // namespace

absl::StatusOr<std::string> service_of(grpc::ByteBuffer& request) {
  if (request.Length() > kMostHealthBytes) {
    request.Clear();
    return absl::InvalidArgumentError("the request for health has more than 1024 bytes");
  }
  grpc::health::v1::HealthCheckRequest message;
  RETURN_IF_ERROR(wire::parse_bounded(request, "HealthCheckRequest", message));
  return message.service();
}

grpc::ByteBuffer health_response(HealthState::Status status) {
  grpc::health::v1::HealthCheckResponse message;
  message.set_status(status);
  const grpc::Slice bytes(message.SerializeAsString());
  return {&bytes, 1};
}

}  // namespace segserve::server
