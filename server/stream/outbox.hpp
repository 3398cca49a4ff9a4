#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "proto/wire/byte_run.hpp"
#include "segserve/v1/stream.pb.h"

namespace segserve::server {

/// An outcome ready to be sent: its message and the bytes of its result.
struct FinishedFrame {
  v1::FrameOutcome outcome;
  wire::OutgoingBytes bytes;
  std::uint64_t credit_bytes = 0;  ///< what the frame took
};

/// Outcomes in the order in which they are sent, each followed by the chunks of its result.
class Outbox {
 public:
  void push(FinishedFrame frame) { frames_.push_back(std::move(frame)); }
  bool empty() const { return frames_.empty(); }
  void clear();

  /// The next message; false if there is none. `returned` is set with the last one of a frame: the bytes of credit
  /// that the client has again once it has read it.
  bool next(v1::SegmentStreamResponse& message, std::optional<std::uint64_t>& returned);

 private:
  std::deque<FinishedFrame> frames_;
  bool outcome_sent_ = false;  // of the first one
};

}  // namespace segserve::server
