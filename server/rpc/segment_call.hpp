// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "segserve/v1/segmentation_service.pb.h"
#include "server/access/access_grant.hpp"
#include "server/access/client_share.hpp"
#include "server/frames/frame_settings.hpp"
#include "server/memory/frame_memory.hpp"
#include "server/observe/frame_record.hpp"
#include "server/rpc/segmentation_service.hpp"
#include "server/scheduling/call_canceler.hpp"
#include "server/scheduling/worker_pool.hpp"

namespace segserve::server {

/// One unary call of Segment from its arrival to its status. Finish happens exactly once: by `start` if the call is
/// refused, by the worker that took the job, by the pool if it evicts the job, or by OnCancel or `abort` if they could
/// withdraw the job before. The object owns itself from `start` to OnDone; the service's UnaryCalls own it, too.
class SegmentCall final : public grpc::ServerUnaryReactor, public std::enable_shared_from_this<SegmentCall> {
 public:
  using Time = FrameSettings::Time;

  /// `grant` says what the caller may do. `response` gets the bytes of a SegmentResponse.
  SegmentCall(SegmentationService& service, AccessGrant grant, grpc::CallbackServerContext& context,
              grpc::ByteBuffer& response);

  /// Parses the request, which empties the buffer, and checks and queues it. Finishes the call if that fails.
  void start(grpc::ByteBuffer& request);
  /// Ends the call if its client has not read the answer for too long.
  void on_tick(Time now);

  /// The server closes: the call ends with UNAVAILABLE, DRAINING as soon as nothing is computed for it any more.
  void abort();

  void OnCancel() override;
  void OnDone() override;

 private:
  absl::Status admit(grpc::ByteBuffer& request);
  absl::Status parse(grpc::ByteBuffer& request);
  void run(std::size_t worker, const FrameSettings& settings);
  absl::Status answer(v1::SegmentationResult result);
  /// Does the same as `finish` for a job that made way for another client.
  void make_way();
  /// Takes the job back if no worker has begun it, and then finishes the call with this status.
  void withdraw(const absl::Status& status);
  void finish(const absl::Status& status);

  SegmentationService& service_;
  const grpc::CallbackServerContext& context_;
  CallCanceler canceler_;
  std::shared_ptr<SegmentCall> self_;
  const AccessGrant grant_;
  const ClientShare share_;
  QuotaLease quota_;
  FrameMemory memory_;
  v1::SegmentRequest request_;
  grpc::ByteBuffer& response_;
  FrameRecord record_;
  const std::optional<Time> deadline_;
  std::atomic<bool> cancelled_{false}, aborted_{false};
  std::atomic<bool> submitted_{false};  // `ticket_` is set
  WorkerPool::Ticket ticket_ = 0;
  std::atomic<Time> finished_at_{Time::max()};
};

}  // namespace segserve::server
