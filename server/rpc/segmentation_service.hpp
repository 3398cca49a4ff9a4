#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "segserve/codec/decode_limits.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"
#include "server/frames/segmentation_backend.hpp"
#include "server/options/server_options.hpp"
#include "server/scheduling/in_flight_calls.hpp"
#include "server/scheduling/worker_pool.hpp"
#include "server/stream/credit_budget.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// Segment as bytes, the others as messages. gRPC answers a request that it cannot parse with a bare
/// UNIMPLEMENTED; parsed by us, it gets the INVALID_ARGUMENT that the API promises.
using RawSegmentationService =
    v1::SegmentationService::WithRawCallbackMethod_Segment<v1::SegmentationService::WithCallbackMethod_SegmentStream<
        v1::SegmentationService::WithCallbackMethod_GetServerInfo<v1::SegmentationService::Service>>>;

/// The RPCs of segserve.v1. Handlers never block: they check the request and hand it to the worker pool.
class SegmentationService final : public RawSegmentationService {
 public:
  /// `options.workers` must not be 0 here.
  SegmentationService(const ServerOptions& options, const BackendFactory& make_backend);

  grpc::ServerUnaryReactor* Segment(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response) override;
  grpc::ServerBidiReactor<v1::SegmentStreamRequest, v1::SegmentStreamResponse>* SegmentStream(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context, const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;

  /// Refuses new calls of Segment and SegmentStream, and new frames, from now on: UNAVAILABLE, DRAINING.
  void start_draining();
  /// Waits for the calls in flight; false if some are left at the deadline.
  bool wait_until_idle_or(std::chrono::steady_clock::time_point deadline) {
    return gate_.wait_until_empty_or(deadline);
  }
  void wait_until_idle() { gate_.wait_until_empty(); }
  /// Calls in flight: waiting, computed, or open streams.
  std::size_t calls() const { return gate_.inside(); }

 private:
  friend class SegmentCall;

  const Options defaults_;
  const std::uint32_t max_threads_;
  const codec::DecodeLimits limits_;
  const v1::GetServerInfoResponse info_;
  const StreamSettings stream_settings_;
  InFlightCalls gate_;
  CreditBudget credit_;
  std::atomic<std::uint64_t> streams_so_far_{0};
  std::vector<std::unique_ptr<SegmentationBackend>> backends_;  // one per worker
  WorkerPool pool_;
  SessionRegistry sessions_;  // ends first, then the pool, and with them whatever uses the others
};

}  // namespace segserve::server
