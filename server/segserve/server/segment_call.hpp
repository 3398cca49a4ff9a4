#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "absl/status/status.h"
#include "grpcpp/server_context.h"
#include "segserve/server/service.hpp"
#include "segserve/server/worker_pool.hpp"
#include "segserve/wire/request.hpp"

namespace segserve::server {

/// One call of Segment from its arrival to its status. Finish happens exactly once: by `start` (refused), by the
/// worker that took the job, or by OnCancel if it could withdraw the job before a worker took it.
class SegmentCall final : public grpc::ServerUnaryReactor {
 public:
  SegmentCall(SegmentationService& service, const grpc::CallbackServerContext& context,
              const v1alpha1::SegmentRequest& request, v1alpha1::SegmentResponse& response);

  /// Checks the request and queues it, or finishes the call.
  void start();

  void OnCancel() override;
  void OnDone() override;

 private:
  absl::Status admit();
  void run(std::size_t worker, const wire::ParsedRequest& parsed);
  void finish(const absl::Status& status);
  StopToken stop_token() const { return StopToken(&cancelled_, deadline_); }

  SegmentationService& service_;
  const grpc::CallbackServerContext& context_;
  const v1alpha1::SegmentRequest& request_;
  v1alpha1::SegmentResponse& response_;
  const std::chrono::steady_clock::time_point arrival_;
  const std::optional<std::chrono::steady_clock::time_point> deadline_;
  std::atomic<bool> cancelled_{false};
  std::optional<WorkerPool::Ticket> ticket_;  // gRPC calls OnCancel only after `start` has returned
};

}  // namespace segserve::server
