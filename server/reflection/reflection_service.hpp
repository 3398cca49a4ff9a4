// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "grpc/reflection/v1/reflection.grpc.pb.h"
#include "grpc/reflection/v1alpha/reflection.grpc.pb.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/reflection/reflection_calls.hpp"

namespace segserve::server {

/// grpc.reflection by one of its two names, with bytes instead of messages. gRPC 1.51 has v1alpha only, and its
/// implementation bounds neither the memory of its messages nor the number of its calls.
template <typename Interface>
class ReflectionService final
    : public Interface::template WithRawCallbackMethod_ServerReflectionInfo<typename Interface::Service> {
 public:
  /// `calls` must outlive the service.
  explicit ReflectionService(ReflectionCalls& calls) : calls_(calls) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* ServerReflectionInfo(
      grpc::CallbackServerContext* context) override {
    return calls_.begin(*context);
  }

 private:
  ReflectionCalls& calls_;
};

using ReflectionV1 = ReflectionService<grpc::reflection::v1::ServerReflection>;
using ReflectionV1Alpha = ReflectionService<grpc::reflection::v1alpha::ServerReflection>;

}  // namespace segserve::server
