// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/calls/channels.hpp"
#include "client/stream/liveness_probe.hpp"
#include "client/stream/stream_scheduler.hpp"
#include "client/stream/stream_transport.hpp"
#include "core/base/mutex.hpp"

namespace segserve::client {

/// The threads of a stream and the lock around its scheduler:
///
/// - the timer thread keeps deadlines, opens and breaks connections, and probes silent ones; it never waits for others;
/// - the callback thread runs StreamOptions::on_outcome, if there is one, and may be blocked by it;
/// - the local thread segments in this process, if the stream may fall back to that;
/// - threads of gRPC bring messages, and the application's own threads send frames and take outcomes.
class StreamThreads final : public StreamTransportListener {
 public:
  StreamThreads(std::shared_ptr<Channels> channels, StreamOptions options);

  void start();
  /// Cancels what is unfinished. Returns when no thread and no call is left.
  void stop() ABSL_LOCKS_EXCLUDED(mutex_);

  // The functions of Stream. `until` unset: waits without limit.
  absl::StatusOr<std::uint64_t> send(Payload payload, FrameOptions options) ABSL_LOCKS_EXCLUDED(mutex_);
  void cancel(std::uint64_t sequence) ABSL_LOCKS_EXCLUDED(mutex_);
  void finish() ABSL_LOCKS_EXCLUDED(mutex_);
  std::optional<Outcome> next(std::optional<Time> until) ABSL_LOCKS_EXCLUDED(mutex_);
  bool done() ABSL_LOCKS_EXCLUDED(mutex_);

  bool next_message(ConnectionId id, OutgoingMessage& outgoing) override ABSL_LOCKS_EXCLUDED(mutex_);
  bool wants_half_close(ConnectionId id) override ABSL_LOCKS_EXCLUDED(mutex_);
  void on_written(ConnectionId id) override ABSL_LOCKS_EXCLUDED(mutex_);
  void on_message(ConnectionId id, v1::SegmentStreamResponse& message) override ABSL_LOCKS_EXCLUDED(mutex_);
  void on_closed(ConnectionId id, const absl::Status& status, bool handshake_failed) override
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void keep_time() ABSL_LOCKS_EXCLUDED(mutex_);
  void update_servers() ABSL_LOCKS_EXCLUDED(mutex_);
  void on_servers_changed() ABSL_LOCKS_EXCLUDED(mutex_);
  void call_back() ABSL_LOCKS_EXCLUDED(mutex_);
  void segment_locally() ABSL_LOCKS_EXCLUDED(mutex_);

  void perform(const LinkAction& action) ABSL_LOCKS_EXCLUDED(mutex_);
  void open(const LinkAction& action) ABSL_LOCKS_EXCLUDED(mutex_);
  void probe(const LinkAction& action) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Gives up a call, its channel, or both.
  void give_up(const LinkAction& action) ABSL_LOCKS_EXCLUDED(mutex_);
  void on_probed(ConnectionId id, bool alive) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Finds out why a handshake failed, on a thread of its own, because gRPC's must not block.
  void diagnose(ConnectionId id, const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void end_connection(ConnectionId id, const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Lets all transports send what they can.
  void pump() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Wakes all that wait for a change.
  void notify() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Waits for a change; false if `until` has passed.
  bool wait(std::optional<Time> until) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Waits for the next outcome; nothing if none can come or `until` has passed.
  std::optional<UndecodedOutcome> wait_for_outcome(std::optional<Time> until) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Waits for a frame to be segmented in this process; nothing once the stream stops.
  std::optional<StreamScheduler::LocalJob> wait_for_local_job() ABSL_LOCKS_EXCLUDED(mutex_);
  /// True if no outcome will come any more, and no callback runs with one.
  bool all_taken() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return scheduler_.exhausted() && !calling_back_; }

  const std::shared_ptr<Channels> channels_;
  const StreamOptions options_;
  std::uint64_t subscription_ = 0;  // to changes of the servers

  Mutex mutex_;
  CondVar changed_;
  std::uint64_t changes_ ABSL_GUARDED_BY(mutex_) = 0;
  StreamScheduler scheduler_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  bool calling_back_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<ConnectionId, std::shared_ptr<StreamTransport>> transports_ ABSL_GUARDED_BY(mutex_);
  bool servers_changed_ ABSL_GUARDED_BY(mutex_) = true;
  std::map<ConnectionId, std::shared_ptr<LivenessProbe>> probes_ ABSL_GUARDED_BY(mutex_);
  /// Each ends with end_connection, after which its thread does no more.
  std::map<ConnectionId, std::shared_ptr<std::jthread>> diagnoses_ ABSL_GUARDED_BY(mutex_);
  /// Transports, probes and diagnoses that have ended. The timer thread destroys them, because threads of gRPC must
  /// not.
  std::vector<std::shared_ptr<void>> ended_ ABSL_GUARDED_BY(mutex_);

  std::atomic<bool> stop_local_{false};
  std::thread timer_thread_;
  std::thread callback_thread_;
  std::thread local_thread_;
};

}  // namespace segserve::client
