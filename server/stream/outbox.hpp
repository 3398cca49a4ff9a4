// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/v1/stream.pb.h"
#include "server/memory/frame_memory.hpp"
#include "server/observe/frame_record.hpp"
#include "server/observe/service_observer.hpp"

namespace segserve::server {

/// An outcome ready to be sent: its message and the bytes of its result.
struct FinishedFrame {
  v1::FrameOutcome outcome;
  wire::OutgoingBytes bytes;
  FrameMemory memory;              ///< of the result, until it is sent
  FrameRecord record;              ///< with the outcome
  std::uint64_t credit_bytes = 0;  ///< that the frame took from the stream's credit
};

/// Outcomes in the order in which they are sent, each followed by the chunks of its result.
class Outbox {
 public:
  void push(FinishedFrame frame) { frames_.push_back(std::move(frame)); }
  bool empty() const { return frames_.empty(); }
  /// Whether an outcome is sent, but not all of its chunks. No other message may come between them.
  bool within_result() const { return outcome_sent_; }
  /// The stream ended with this status: nothing more is sent. Tells the observers of the frames.
  void abandon_all(const absl::Status& why, FrameRecord::Time now, const ServiceObservers& observers) noexcept;

  /// Fills in the next message; false if there is none. With the last message of a frame, `sent` gets that frame, whose
  /// credit the client has again once it has read that message.
  bool next(v1::SegmentStreamResponse& message, std::optional<FinishedFrame>& sent);

 private:
  std::deque<FinishedFrame> frames_;
  bool outcome_sent_ = false;  // the first frame's outcome is sent, but not all of its chunks
};

}  // namespace segserve::server
