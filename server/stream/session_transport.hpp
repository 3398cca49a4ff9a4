// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "grpcpp/support/server_callback.h"
#include "segserve/v1/stream.pb.h"
#include "server/scheduling/in_flight_calls.hpp"
#include "server/stream/credit_budget.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The gRPC call of one SegmentStream. At most one read and one write are under way, and Finish happens exactly once,
/// when the session has ended. The object owns itself from `start` to OnDone; while a session wakes it, that owns it
/// too.
class SessionTransport final : public grpc::ServerBidiReactor<v1::SegmentStreamRequest, v1::SegmentStreamResponse>,
                               public std::enable_shared_from_this<SessionTransport> {
 public:
  /// `calls` has admitted this call, which leaves it last of all.
  SessionTransport(InFlightCalls& calls, SessionRegistry& registry, std::unique_ptr<FrameExecutor> executor)
      : calls_(calls), registry_(registry), executor_(std::move(executor)) {}

  /// Makes the session and begins to read.
  void start(const StreamSettings& settings, CreditBudget& budget);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void read();
  /// Writes what there is to write, or ends the call.
  void advance();

  InFlightCalls& calls_;
  SessionRegistry& registry_;
  const std::unique_ptr<FrameExecutor> executor_;
  std::shared_ptr<StreamSession> session_;
  std::shared_ptr<SessionTransport> self_;
  v1::SegmentStreamRequest request_;    // gRPC's while a read is under way
  v1::SegmentStreamResponse response_;  // gRPC's while a write is under way
  Mutex mutex_;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::server
