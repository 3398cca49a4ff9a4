// SPDX-License-Identifier: Apache-2.0
#include "server/stream/outbox.hpp"

#include <utility>

namespace segserve::server {

void Outbox::abandon_all(const absl::Status& why, FrameRecord::Time now, const ServiceObservers& observers) noexcept {
  for (FinishedFrame& frame : frames_) {
    end_with_stream(frame.record, why, now);
    observers.on_frame(frame.record);
  }
  frames_.clear();
  outcome_sent_ = false;
}

bool Outbox::next(v1::SegmentStreamResponse& message, std::optional<FinishedFrame>& sent) {
  if (frames_.empty()) return false;
  FinishedFrame& frame = frames_.front();
  if (!outcome_sent_) {
    *message.mutable_outcome() = frame.outcome;  // a copy, since the chunks need its sequence; it holds no bytes
    outcome_sent_ = true;
  } else {
    v1::ResultChunk& chunk = *message.mutable_chunk();
    chunk.set_sequence(frame.outcome.sequence());
    const std::string_view bytes = frame.bytes.next();
    chunk.set_data(bytes.data(), bytes.size());
  }
  frame.record.sent_bytes += message.ByteSizeLong();
  if (frame.bytes.done()) {
    sent = std::move(frame);
    frames_.pop_front();
    outcome_sent_ = false;
  }
  return true;
}

}  // namespace segserve::server
