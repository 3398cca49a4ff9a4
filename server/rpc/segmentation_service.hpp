// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "segserve/v1/segmentation_service.grpc.pb.h"
#include "server/frames/frame_resolver.hpp"
#include "server/frames/segmentation_backend.hpp"
#include "server/memory/memory_ledger.hpp"
#include "server/memory/memory_return.hpp"
#include "server/options/server_options.hpp"
#include "server/rpc/unary_calls.hpp"
#include "server/scheduling/in_flight_calls.hpp"
#include "server/scheduling/worker_pool.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The generated service with bytes instead of messages. They are parsed by wire::parse_bounded, because gRPC would
/// build any message before our code sees it. gRPC also answers a request that it cannot parse with a bare
/// UNIMPLEMENTED, and ends a stream with OK.
using RawSegmentationService =
    v1::SegmentationService::WithRawCallbackMethod_Segment<v1::SegmentationService::WithRawCallbackMethod_SegmentStream<
        v1::SegmentationService::WithRawCallbackMethod_GetServerInfo<v1::SegmentationService::Service>>>;

/// The RPCs of segserve.v1. Handlers never block: they check the request and hand it to the worker pool.
class SegmentationService final : public RawSegmentationService {
 public:
  /// `options.workers` and `options.memory` must not be 0 here.
  SegmentationService(const ServerOptions& options, const BackendFactory& make_backend);

  grpc::ServerUnaryReactor* Segment(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SegmentStream(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;

  /// From now on, new calls of Segment and SegmentStream and new frames are refused with UNAVAILABLE, DRAINING.
  void start_draining();
  /// Ends all calls in flight with UNAVAILABLE, DRAINING as soon as nothing is computed for them any more.
  void abort_calls();
  /// Waits for the calls in flight; false if some are left at the deadline.
  bool wait_until_idle_or(std::chrono::steady_clock::time_point deadline) {
    return calls_.wait_until_none_or(deadline);
  }
  void wait_until_idle() { calls_.wait_until_none(); }
  /// Unary calls that wait or are computed, and open streams.
  std::size_t calls_in_flight() const { return calls_.count(); }

 private:
  friend class SegmentCall;

  void free_buffers(std::size_t worker);

  MemoryLedger ledger_;
  MemoryReturn memory_return_;
  const std::uint64_t max_voxels_;
  const FrameResolver resolver_;
  const v1::GetServerInfoResponse info_;
  const StreamSettings stream_settings_;
  InFlightCalls calls_;
  std::atomic<std::uint64_t> streams_so_far_{0};
  UnaryCalls unary_calls_;
  std::vector<std::unique_ptr<SegmentationBackend>> backends_;  // one per worker
  // The members below are destroyed first, and with them everything that uses those above.
  WorkerPool pool_;
  SessionRegistry sessions_;
};

}  // namespace segserve::server
