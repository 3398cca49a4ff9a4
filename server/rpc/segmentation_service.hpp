// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "segserve/v1/segmentation_service.grpc.pb.h"
#include "server/access/access_control.hpp"
#include "server/frames/frame_resolver.hpp"
#include "server/frames/segmentation_backend.hpp"
#include "server/memory/memory_ledger.hpp"
#include "server/memory/memory_return.hpp"
#include "server/observe/service_observer.hpp"
#include "server/observe/service_state.hpp"
#include "server/options/server_options.hpp"
#include "server/rpc/proofs_of.hpp"
#include "server/rpc/unary_calls.hpp"
#include "server/scheduling/in_flight_calls.hpp"
#include "server/scheduling/ticker.hpp"
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
  /// `options.workers` and `options.memory` must not be 0 here. `access` decides who may call. The observers learn of
  /// every frame and stream.
  SegmentationService(const ServerOptions& options, std::unique_ptr<AccessControl> access,
                      const BackendFactory& make_backend, ServiceObservers observers);

  grpc::ServerUnaryReactor* Segment(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SegmentStream(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;

  /// Whether the caller may ask about the server by this RPC; UNAUTHENTICATED otherwise, of which observers learn.
  absl::Status admit_question(const grpc::CallbackServerContext& context, std::string_view rpc);

  /// Refuses new calls of Segment and SegmentStream and new frames from now on, with UNAVAILABLE, DRAINING.
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
  ServiceState state() const;

  /// The parts that calls by another transport than gRPC need. They must end before the service does.
  struct Parts {
    AccessControl& access;
    MemoryLedger& ledger;
    std::uint64_t max_voxels;
    const FrameResolver& resolver;
    const v1::GetServerInfoResponse& info;
    const StreamSettings& settings;  ///< how long uploads and answers may take
    const ServiceObservers& observers;
    InFlightCalls& calls;
    std::vector<std::unique_ptr<SegmentationBackend>>& backends;
    WorkerPool& pool;
  };
  Parts parts() {
    return {*access_, ledger_, max_voxels_, resolver_, info_, stream_settings_, observers_, calls_, backends_, pool_};
  }

 private:
  friend class SegmentCall;

  void free_buffers(std::size_t worker);
  /// Ends a unary call of Segment that does not become a SegmentCall.
  grpc::ServerUnaryReactor* refuse_call(grpc::CallbackServerContext& context, const absl::Status& why) noexcept;
  /// Ends a stream that does not become a SessionTransport.
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* refuse_stream(grpc::CallbackServerContext& context,
                                                                             const absl::Status& why) noexcept;

  const ServiceObservers observers_;
  const std::unique_ptr<AccessControl> access_;
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
  Ticker access_watch_;
};

}  // namespace segserve::server
