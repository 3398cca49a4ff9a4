// SPDX-License-Identifier: Apache-2.0
#include "server/stream/outbox.hpp"

namespace segserve::server {

void Outbox::clear() {
  frames_.clear();
  outcome_sent_ = false;
}

bool Outbox::next(v1::SegmentStreamResponse& message, std::optional<std::uint64_t>& returned_bytes) {
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
  if (frame.bytes.done()) {
    returned_bytes = frame.credit_bytes;
    frames_.pop_front();
    outcome_sent_ = false;
  }
  return true;
}

}  // namespace segserve::server
