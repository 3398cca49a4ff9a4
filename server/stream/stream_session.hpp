// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.hpp"
#include "proto/wire/request_message.hpp"
#include "segserve/v1/stream.pb.h"
#include "server/access/access_grant.hpp"
#include "server/frames/frame_resolver.hpp"
#include "server/frames/segmentation_backend.hpp"
#include "server/memory/memory_ledger.hpp"
#include "server/observe/service_observer.hpp"
#include "server/stream/credit.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/outbox.hpp"
#include "server/stream/session_protocol.hpp"
#include "server/stream/session_scheduler.hpp"
#include "server/stream/stream_frame.hpp"

namespace segserve::server {

/// The settings that all streams of a server have in common.
struct StreamSettings {
  using Clock = std::chrono::steady_clock;

  FrameResolver resolver;                          ///< makes the settings of every frame
  CreditLimits credit = {};                        ///< of every stream
  MemoryLedger* ledger = nullptr;                  ///< from which frames lease memory; null: they are not bounded
  std::uint64_t max_voxels = 0;                    ///< of a frame
  v1::StreamOpened greeting = {};                  ///< the answer to StreamOpen without the credit
  ServiceObservers observers = {};                 ///< learn of every frame
  std::chrono::milliseconds upload_timeout{5000};  ///< between two chunks of a frame
  /// A frame's upload may at any time have taken `upload_grace` and the time of the bytes that have come, at this rate,
  /// bytes per second. While others find no memory, it has a shorter grace, and must be on the way to be complete
  /// within `short_upload_time`, because a header alone holds the memory of the whole payload.
  std::uint64_t least_upload_rate = std::uint64_t{16} << 10U;
  std::chrono::milliseconds upload_grace{10'000}, short_upload_grace{2'000}, short_upload_time{30'000};
  /// The time for the client to read a message; the shorter one while others find no memory.
  std::chrono::milliseconds result_timeout{30'000}, short_result_timeout{3'000};
  std::chrono::milliseconds idle_timeout{600'000};  ///< without a message or a frame; the stream ends then
  /// After this time, give or take a tenth at random, the client is asked to open another stream; 0: never. So streams
  /// that began together do not all come again together. Frames are taken for `age_grace` more.
  std::chrono::milliseconds max_age{0}, age_grace{20'000};
  std::function<Clock::time_point()> now = Clock::now;

  bool is_memory_short() const { return ledger != nullptr && ledger->is_short(); }
  std::chrono::milliseconds result_timeout_now() const {
    return is_memory_short() ? short_result_timeout : result_timeout;
  }
  UploadPace upload_pace_now() const {
    constexpr std::chrono::hours kAnyTime{24 * 365};
    return is_memory_short() ? UploadPace{upload_timeout, short_upload_grace, least_upload_rate, short_upload_time}
                             : UploadPace{upload_timeout, upload_grace, least_upload_rate, kAnyTime};
  }
};

/// One SegmentStream without its transport: takes the client's messages, has the frames computed, and gives out the
/// server's messages. It puts a lock around SessionProtocol and SessionScheduler and connects them with the workers.
/// stream.proto says what both sides may do. Thread-safe; no function waits for a computation.
///
/// The transport calls the functions `on_...` as things happen. Whenever `wake` was called, it asks `next` until that
/// returns false, and then `ended`. `wake` may be called from any thread, also shortly after the end, but never with a
/// lock held.
class StreamSession : public std::enable_shared_from_this<StreamSession> {
 public:
  /// `owner` is whose memory the frames are, and `caller` who sends them, who may do what `grant` says. Settings and
  /// executor must outlive the session's work, which is over after `ended`. Later only jobs that are still in the queue
  /// may use the session.
  StreamSession(const StreamSettings& settings, MemoryOwner owner, Caller caller, FrameExecutor& executor,
                std::function<void()> wake, AccessGrant grant = {});

  /// May take parts of the message.
  void on_message(v1::SegmentStreamRequest& message);
  /// A message came that cannot be parsed; `why` says so.
  void on_broken_message(const absl::Status& why);
  /// The client sends no more.
  void on_half_close();
  /// The transport is gone, or its deadline has passed. The session ends with this status as soon as nothing is
  /// computed any more.
  void on_cancel(const absl::Status& why);
  /// Later frames are refused. The session ends when the present ones have.
  void start_draining();
  /// Looks for frames whose time is over. To be called about ten times a second.
  void on_tick();

  /// Fills in the next message to send; false if there is none now.
  bool next(v1::SegmentStreamResponse& message);
  /// The status of the stream, once nothing is left to do or to send.
  std::optional<absl::Status> ended() const;
  /// Ends the session with this status as soon as nothing is computed any more, without calling `wake`.
  void end(const absl::Status& status);

  /// Makes the record of a stream that ended with this status.
  StreamRecord record(const absl::Status& end) const;
  /// Frames whose outcome has not been handed to the transport.
  std::size_t frames_in_flight() const;

 private:
  /// Runs a function that returns a status, with the lock held, and then wakes the transport. The session ends if the
  /// status is not OK, or if there is no memory for what the function does.
  template <typename Function>
  void change(Function&& function);
  /// Asks the client to move on once the stream is old, and drains when the grace is over, too.
  void look_at_age(StreamFrame::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status handle(v1::SegmentStreamRequest& message) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status open(const v1::StreamOpen& message) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void begin(const StreamFramePointer& frame) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void enqueue(const StreamFramePointer& frame) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Asks the resolver and the limits for what the frame needs.
  absl::Status admit(StreamFrame& frame) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Unless it is OK, later frames fail with this status, and the client is told to open another stream.
  void close_with(const absl::Status& why, v1::DrainReason reason) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void end_with(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Computes a frame on a worker's thread.
  void compute(const StreamFramePointer& frame, SegmentationBackend& backend);

  const StreamSettings& settings_;
  const MemoryOwner owner_;
  const std::function<void()> wake_;

  mutable Mutex mutex_;
  Outbox outbox_ ABSL_GUARDED_BY(mutex_);
  SessionProtocol protocol_ ABSL_GUARDED_BY(mutex_);
  SessionScheduler scheduler_ ABSL_GUARDED_BY(mutex_);
  wire::ParsedRequest defaults_ ABSL_GUARDED_BY(mutex_);  // of frames that do not say it themselves
  std::shared_ptr<const Caller> caller_ ABSL_GUARDED_BY(mutex_);
  const StreamFrame::Time began_;
  std::uint64_t frames_ ABSL_GUARDED_BY(mutex_) = 0;  // that have begun
  StreamFrame::Time old_at_ ABSL_GUARDED_BY(mutex_) = StreamFrame::Time::max();
  bool told_age_ ABSL_GUARDED_BY(mutex_) = false;
  AccessGrant grant_ ABSL_GUARDED_BY(mutex_);
  StreamFrame::Time proof_checked_ ABSL_GUARDED_BY(mutex_);
  absl::Status closing_ ABSL_GUARDED_BY(mutex_);  // not OK: why no more frames are taken
  StreamFrame::Time last_message_
      ABSL_GUARDED_BY(mutex_);  // from the client, or the last time that a frame was in flight
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);  // set before its time: by a fault, or from outside
};

}  // namespace segserve::server
