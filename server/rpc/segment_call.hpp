// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "segserve/v1/segmentation_service.pb.h"
#include "server/frames/frame_settings.hpp"
#include "server/rpc/segmentation_service.hpp"
#include "server/scheduling/worker_pool.hpp"

namespace segserve::server {

/// One unary call of Segment from its arrival to its status. Finish happens exactly once: by `start` if the call is
/// refused, by the worker that took the job, by the pool if it evicts the job, or by OnCancel if that could withdraw
/// the job before. Deletes itself in OnDone.
class SegmentCall final : public grpc::ServerUnaryReactor {
 public:
  /// `response` gets the bytes of a SegmentResponse.
  SegmentCall(SegmentationService& service, const grpc::CallbackServerContext& context, grpc::ByteBuffer& response);

  /// Parses the request, which empties the buffer, and checks and queues it. Finishes the call if that fails.
  void start(grpc::ByteBuffer& request);

  void OnCancel() override;
  void OnDone() override;

 private:
  absl::Status admit(grpc::ByteBuffer& request);
  absl::Status parse(grpc::ByteBuffer& request);
  void run(std::size_t worker, const FrameSettings& settings);
  absl::Status answer(v1::SegmentationResult result);
  void finish(const absl::Status& status);

  SegmentationService& service_;
  const grpc::CallbackServerContext& context_;
  v1::SegmentRequest request_;
  v1::ResultSummary summary_;  // of the answer, for the log
  grpc::ByteBuffer& response_;
  const FrameSettings::Time arrival_;
  const std::optional<FrameSettings::Time> deadline_;
  std::atomic<bool> cancelled_{false};
  std::optional<WorkerPool::Ticket> ticket_;  // gRPC calls OnCancel only after `start` has returned
};

}  // namespace segserve::server
