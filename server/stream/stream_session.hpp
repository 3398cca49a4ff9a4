#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "segserve/v1/stream.pb.h"
#include "server/frames/frame_resolver.hpp"
#include "server/stream/credit_budget.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/outbox.hpp"
#include "server/stream/stream_frame.hpp"

namespace segserve::server {

/// What all streams of a server have in common.
struct StreamSettings {
  using Clock = std::chrono::steady_clock;

  FrameResolver resolver;                          ///< makes the settings of every frame
  std::chrono::milliseconds upload_timeout{5000};  ///< between two chunks of a frame
  v1::StreamOpened greeting = {};                  ///< the answer to StreamOpen without the credit
  std::function<Clock::time_point()> now = Clock::now;
};

/// One SegmentStream without its transport: takes the client's messages, has the frames computed, and gives out the
/// server's messages. stream.proto says what both sides may do. Thread-safe; no function waits for a computation.
///
/// The transport calls `on_...` as things happen, and whenever `wake` was called asks `next` until it is false, and
/// then `ended`. `wake` may be called from any thread, never with a lock held, and a little after the end, too.
class StreamSession : public std::enable_shared_from_this<StreamSession> {
 public:
  /// Settings, executor and budget must outlive the session's work: until `ended` and `close`.
  StreamSession(const StreamSettings& settings, FrameExecutor& executor, CreditBudget& budget,
                std::function<void()> wake);

  /// May take parts of the message.
  void on_message(v1::SegmentStreamRequest& message);
  /// The client sends no more.
  void on_half_close();
  /// The transport is gone, or its deadline has passed: ends with this status as soon as nothing is computed any more.
  void on_cancel(const absl::Status& why);
  /// Later frames are refused; ends when the present ones have.
  void start_draining();
  /// Looks for frames whose time is over. To be called about ten times a second.
  void on_tick();

  /// The next message to send; false if there is none at present.
  bool next(v1::SegmentStreamResponse& message);
  /// The status of the stream, once nothing is left to do or to send.
  std::optional<absl::Status> ended() const;
  /// Gives the credit back. Nothing may be called after it but by jobs that are still in the queue.
  void close();

  /// Frames without an outcome.
  std::size_t frames_in_flight() const;

 private:
  using FramePointer = std::shared_ptr<StreamFrame>;
  using Clock = StreamSettings::Clock;

  // All of these expect the lock.
  absl::Status handle(v1::SegmentStreamRequest& message);
  absl::Status open(const v1::StreamOpen& message);
  absl::Status begin_frame(v1::FrameHeader& header);
  absl::Status resolve(StreamFrame& frame);
  absl::Status take_credit(const v1::FrameHeader& header);
  absl::Status take_chunk(const v1::FrameChunk& chunk);
  void cancel_frame(std::uint64_t sequence);
  void uploaded(const FramePointer& frame);
  absl::Status submit(const FramePointer& frame);
  bool drop_oldest();
  void stop(const FramePointer& frame, v1::OutcomeKind kind);
  void finish(const FramePointer& frame, v1::OutcomeKind kind, const absl::Status& status);
  void finish(const FramePointer& frame, FinishedFrame finished);
  void send_in_order();
  void end_with(const absl::Status& status);

  /// On a worker.
  void run(const FramePointer& frame, SegmentationBackend& segmenter);

  const StreamSettings& settings_;
  FrameExecutor& executor_;
  CreditBudget& budget_;
  const std::function<void()> wake_;

  mutable std::mutex mutex_;
  CreditBudget::Reservation credit_;
  Credit used_;
  std::string client_name_;
  wire::ParsedRequest defaults_;  // of a frame that says nothing
  v1::ResultOrder order_ = v1::RESULT_ORDER_ORDERED;
  v1::WhenBehind when_behind_ = v1::WHEN_BEHIND_BLOCK;
  bool open_ = false, half_closed_ = false, draining_ = false;
  bool must_send_opened_ = false, must_send_draining_ = false;
  std::optional<absl::Status> end_;               // set early: by a fault, or from outside
  std::map<std::uint64_t, FramePointer> frames_;  // whose outcome has not gone to the outbox, by sequence
  FramePointer upload_;                           // whose chunks come or came last
  std::uint64_t last_sequence_ = 0;
  bool has_sequence_ = false;
  std::size_t running_ = 0;  // frames that workers have
  Outbox outbox_;
};

}  // namespace segserve::server
