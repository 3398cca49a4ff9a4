#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "proto/wire/request_message.hpp"
#include "server/rpc/segmentation_service.hpp"
#include "server/scheduling/worker_pool.hpp"

namespace segserve::server {

/// One call of Segment from its arrival to its status. Finish happens exactly once: by `start` (refused), by the
/// worker that took the job, by the pool if it evicts the job, or by OnCancel if it could withdraw the job before that.
class SegmentCall final : public grpc::ServerUnaryReactor {
 public:
  /// `response` gets the bytes of a SegmentResponse.
  SegmentCall(SegmentationService& service, const grpc::CallbackServerContext& context, grpc::ByteBuffer& response);

  /// Parses the request, which empties the buffer, checks and queues it; or finishes the call.
  void start(grpc::ByteBuffer& request);

  void OnCancel() override;
  void OnDone() override;

 private:
  absl::Status admit(grpc::ByteBuffer& request);
  void run(std::size_t worker, const wire::ParsedRequest& parsed);
  absl::Status answer(absl::StatusOr<v1::SegmentationResult> result);
  void finish(const absl::Status& status);
  StopToken stop_token() const { return StopToken(&cancelled_, deadline_); }

  SegmentationService& service_;
  const grpc::CallbackServerContext& context_;
  v1::SegmentRequest request_;
  v1::ResultSummary summary_;  // of the answer, for the log
  grpc::ByteBuffer& response_;
  const std::chrono::steady_clock::time_point arrival_;
  const std::optional<std::chrono::steady_clock::time_point> deadline_;
  std::atomic<bool> cancelled_{false};
  std::optional<WorkerPool::Ticket> ticket_;  // gRPC calls OnCancel only after `start` has returned
};

}  // namespace segserve::server
