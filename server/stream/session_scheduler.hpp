// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/v1/stream.pb.h"
#include "server/frames/segmentation_backend.hpp"
#include "server/observe/service_observer.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/outbox.hpp"
#include "server/stream/stream_frame.hpp"

namespace segserve::server {

/// Decides for the frames of one stream which of them are computed, which are left out, and in which order their
/// outcomes are sent. Every frame that was added has exactly one outcome, unless the stream ends before. It knows
/// neither messages nor transport nor clock. One thread at a time may use it.
class SessionScheduler {
 public:
  using Time = StreamFrame::Time;
  using Computation = std::function<void(SegmentationBackend&)>;

  /// All must outlive this object.
  SessionScheduler(FrameExecutor& executor, Outbox& outbox, const ServiceObservers& observers)
      : executor_(executor), outbox_(outbox), observers_(observers) {}

  /// Takes the order of outcomes and what happens when the server is behind from the client's wishes.
  void set_policy(const v1::StreamOpen& open);

  /// A new frame, whose payload is still to come.
  void add(const StreamFramePointer& frame);
  /// Queues a frame whose payload has come. The job calls `compute` on a worker, which calls `start` and `complete`.
  void submit(const StreamFramePointer& frame, const Computation& compute, Time now);
  /// A worker has taken the frame. False if it must not be computed: its outcome is known, it was cancelled, or there
  /// is not enough time left for it, which ends it as EXPIRED.
  bool start(const StreamFramePointer& frame, Time now);
  /// A worker has computed the frame, which `start` allowed.
  void complete(const StreamFramePointer& frame, absl::StatusOr<FinishedFrame> computed, Time now);

  /// The frame ends as FAILED.
  void fail(const StreamFramePointer& frame, const absl::Status& status, Time now);
  /// The frame ends as CANCELLED, unless its outcome is known already. Unknown frames are ignored.
  void cancel(std::uint64_t sequence, Time now);
  /// Frames whose time to live is over end as EXPIRED.
  void expire(Time now);
  /// The stream has ended with this status: forgets all frames, without outcomes, and stops the computation of those
  /// that have begun. Tells the observers of each frame when nothing is done for it any more.
  void abandon_all(const absl::Status& why, Time now);

  /// Frames without an outcome, or with one that waits for those of earlier frames.
  std::size_t in_flight() const { return frames_.size(); }
  /// Frames that workers have.
  std::size_t running() const { return running_; }

 private:
  bool may_exceed_queue() const;
  bool drop_oldest(const StreamFrame& newest, Time now);
  void stop(const StreamFramePointer& frame, v1::OutcomeKind kind, Time now);
  void finish(const StreamFramePointer& frame, v1::OutcomeKind kind, const absl::Status& status, Time now);
  void finish(const StreamFramePointer& frame, FinishedFrame finished, const absl::Status& status, Time now);
  void abandon(StreamFrame& frame, Time now);
  void send_in_order();

  FrameExecutor& executor_;
  Outbox& outbox_;
  const ServiceObservers& observers_;
  v1::ResultOrder order_ = v1::RESULT_ORDER_ORDERED;
  v1::WhenBehind when_behind_ = v1::WHEN_BEHIND_BLOCK;
  std::map<std::uint64_t, StreamFramePointer> frames_;  // whose outcome has not gone to the outbox, by sequence
  std::size_t running_ = 0;
  std::optional<absl::Status> abandoned_;  // why, if all frames were abandoned
};

}  // namespace segserve::server
