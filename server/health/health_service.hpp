// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "grpc/health/v1/health.grpc.pb.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/health/health_state.hpp"

namespace segserve::server {

/// The generated service with bytes instead of messages.
using RawHealthService = grpc::health::v1::Health::WithRawCallbackMethod_Check<
    grpc::health::v1::Health::WithRawCallbackMethod_Watch<grpc::health::v1::Health::Service>>;

/// grpc.health.v1. gRPC's own implementation belongs to one server, bounds neither the number of watches nor the size
/// of requests, and keeps a server from stopping while somebody watches.
class HealthService final : public RawHealthService {
 public:
  /// Several services, each in a server of gRPC, may have the same state, which must outlive them.
  explicit HealthService(HealthState& state) : state_(state) {}

  grpc::ServerUnaryReactor* Check(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                  grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Watch(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request) override;

 private:
  HealthState& state_;
};

}  // namespace segserve::server
