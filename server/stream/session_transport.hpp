// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/access/access_grant.hpp"
#include "server/memory/memory_ledger.hpp"
#include "server/scheduling/call_canceler.hpp"
#include "server/scheduling/in_flight_calls.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The gRPC call of one SegmentStream. At most one read and one write are under way, and Finish happens exactly once,
/// when the session has ended. The object owns itself from `start` to OnDone; while a session wakes it, that owns it
/// too.
class SessionTransport final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                               public std::enable_shared_from_this<SessionTransport> {
 public:
  /// `calls` has admitted this call, which leaves it last of all.
  SessionTransport(grpc::CallbackServerContext& context, InFlightCalls& calls, SessionRegistry& registry,
                   std::unique_ptr<FrameExecutor> executor)
      : canceler_(context), calls_(calls), registry_(registry), executor_(std::move(executor)) {}

  /// Makes the session. It must have returned, and not thrown, before `start`. The settings must outlive this object.
  void prepare(const StreamSettings& settings, MemoryOwner owner, Caller caller, AccessGrant grant);
  /// Begins to read.
  void start() noexcept;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void read();
  /// The client is gone: ends the session as soon as nothing is computed for it any more.
  void end_call(const char* why);
  /// Writes what there is to write, or ends the call. Ends it also if the client has not read a message for too long.
  void advance();
  /// Serializes the next message of the session into `response_`; false if there is none.
  absl::StatusOr<bool> next_response();

  CallCanceler canceler_;
  InFlightCalls& calls_;
  SessionRegistry& registry_;
  const std::unique_ptr<FrameExecutor> executor_;
  std::shared_ptr<StreamSession> session_;
  std::shared_ptr<SessionTransport> self_;
  grpc::ByteBuffer request_;                  // gRPC's while a read is under way
  grpc::ByteBuffer response_;                 // gRPC's while a write is under way
  const StreamSettings* settings_ = nullptr;  // set by `prepare`
  Mutex mutex_;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  StreamSettings::Clock::time_point write_began_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::server
