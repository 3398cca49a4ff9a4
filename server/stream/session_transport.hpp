#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "server/scheduling/in_flight_calls.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The transport of one SegmentStream: at most one read and one write are on their way, and Finish happens exactly
/// once, when the session has ended. Belongs to itself from `start` to OnDone, and to whoever wakes it.
class SessionTransport final : public grpc::ServerBidiReactor<v1::SegmentStreamRequest, v1::SegmentStreamResponse>,
                               public std::enable_shared_from_this<SessionTransport> {
 public:
  /// `gate` was entered for this call, which leaves it last of all.
  SessionTransport(InFlightCalls& gate, SessionRegistry& registry, std::unique_ptr<FrameExecutor> executor)
      : gate_(gate), registry_(registry), executor_(std::move(executor)) {}

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

  InFlightCalls& gate_;
  SessionRegistry& registry_;
  const std::unique_ptr<FrameExecutor> executor_;
  std::shared_ptr<StreamSession> session_;
  std::shared_ptr<SessionTransport> self_;
  v1::SegmentStreamRequest request_;    // gRPC's while a read is on its way
  v1::SegmentStreamResponse response_;  // gRPC's while a write is
  std::mutex mutex_;
  bool writing_ = false, finished_ = false;
};

}  // namespace segserve::server
