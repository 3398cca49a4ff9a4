// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::client {

/// Asks a server something that any living one answers at once, even while it computes. Must live until `done` was
/// called, and must not be destroyed on the thread of that call.
class LivenessProbe {
 public:
  explicit LivenessProbe(const std::shared_ptr<grpc::Channel>& channel) : stub_(channel) {}

  /// The context of the call, before `start`.
  grpc::ClientContext& context() { return context_; }
  /// Calls `done` once, on a thread of gRPC: with true if the server answered within `timeout`, be it with a refusal.
  void start(std::chrono::milliseconds timeout, std::function<void(bool alive)> done);
  /// The answer is not wanted any more: `done` is called soon, with false.
  void cancel() { context_.TryCancel(); }

 private:
  v1::SegmentationService::Stub stub_;
  grpc::ClientContext context_;
  v1::GetServerInfoRequest request_;
  v1::GetServerInfoResponse response_;
};

}  // namespace segserve::client
