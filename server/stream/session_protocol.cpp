// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_protocol.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/tracking.hpp"
#include "server/stream/protocol_violation.hpp"

namespace segserve::server {
namespace {

// The state of tracks, and some bytes for the shape, the options, the prompts and the layout of a frame, of which the
// largest are 64 cameras and 128 prompts. The payload comes in chunks.
constexpr std::size_t kMostHeaderBytes = TrackState::kMostBytes + (std::size_t{64} << 10U);

// See SessionProtocol::cut_off_upload.
constexpr std::chrono::milliseconds kMoment{100};

}  // namespace

absl::StatusOr<SessionProtocol::Event> SessionProtocol::receive(v1::SegmentStreamRequest& message, Time now) {
  using Kind = v1::SegmentStreamRequest::KindCase;
  if (open_ == message.has_open()) {
    return protocol_violation(open_ ? "a second StreamOpen" : "the first message must be a StreamOpen");
  }
  switch (message.kind_case()) {
    case Kind::kOpen:
      return Event{.kind = Event::kOpen};
    case Kind::kFrame: {
      const std::uint64_t bytes = message.ByteSizeLong();
      ASSIGN_OR_RETURN(const Event event, begin_frame(*message.mutable_frame(), now));
      event.frame->record.received_bytes = bytes;
      return event;
    }
    case Kind::kChunk:
      if (upload_) upload_->record.received_bytes += message.ByteSizeLong();
      return take_chunk(message.chunk(), now);
    case Kind::kCancel:
      return Event{.kind = Event::kCancel, .sequence = message.cancel().sequence()};
    case Kind::KIND_NOT_SET:
      break;
  }
  return protocol_violation("a message of no kind that this server knows");
}

void SessionProtocol::grant(const Credit& credit) {
  credit_ = credit;
  open_ = must_send_opened_ = true;
}

absl::StatusOr<SessionProtocol::Event> SessionProtocol::begin_frame(v1::FrameHeader& header, Time now) {
  const std::uint64_t sequence = header.sequence();
  if (last_sequence_ && sequence <= *last_sequence_) {
    return protocol_violation(fmt::format("frame {} comes after frame {}", sequence, *last_sequence_));
  }
  if (is_uploading()) {
    return protocol_violation(fmt::format("frame {} begins with {} bytes of frame {} missing", sequence,
                                          upload_->payload.missing(), *last_sequence_));
  }
  if (header.ByteSizeLong() > kMostHeaderBytes) {
    return protocol_violation(fmt::format("the header of frame {} has more than {} bytes", sequence, kMostHeaderBytes));
  }
  RETURN_IF_ERROR(take_credit(header));
  last_sequence_ = sequence;
  upload_began_ = last_chunk_ = now;
  upload_ = std::make_shared<StreamFrame>(std::move(header), now);
  return Event{.kind = Event::kBegun, .frame = upload_};
}

absl::Status SessionProtocol::take_credit(const v1::FrameHeader& header) {
  const Credit& granted = credit_;
  if (used_.frames == granted.frames) {
    return protocol_violation(
        fmt::format("frame {} is beyond the credit of {} frames", header.sequence(), granted.frames));
  }
  if (header.encoded_bytes() > granted.bytes - used_.bytes) {
    return protocol_violation(fmt::format("frame {} of {} bytes is beyond the credit of {} bytes, of which {} are left",
                                          header.sequence(), header.encoded_bytes(), granted.bytes,
                                          granted.bytes - used_.bytes));
  }
  used_.frames += 1;
  used_.bytes += header.encoded_bytes();
  return absl::OkStatus();
}

absl::StatusOr<SessionProtocol::Event> SessionProtocol::take_chunk(const v1::FrameChunk& chunk, Time now) {
  if (!upload_ || chunk.sequence() != *last_sequence_) {
    return protocol_violation(
        fmt::format("a chunk of frame {}, which is not the last that has begun", chunk.sequence()));
  }
  if (chunk.data().empty() || chunk.data().size() > wire::kMaxChunkBytes) {
    return protocol_violation(
        fmt::format("a chunk of {} bytes; allowed are 1 to {}", chunk.data().size(), wire::kMaxChunkBytes));
  }
  if (upload_->state == StreamFrame::State::kDone) return Event{};  // the chunk was on its way when the frame ended
  if (!upload_->payload.add(chunk.data())) {
    return protocol_violation(fmt::format("more bytes of frame {} than its header announced, {}", chunk.sequence(),
                                          upload_->header.encoded_bytes()));
  }
  last_chunk_ = now;
  if (upload_->payload.missing() > 0) return Event{};
  return Event{.kind = Event::kUploaded, .frame = upload_};
}

StreamFramePointer SessionProtocol::cut_off_upload(Time now) const {
  return half_closed_ && now - *half_closed_ >= kMoment && is_uploading() ? upload_ : nullptr;
}

StreamFramePointer SessionProtocol::stalled_upload(Time now, const UploadPace& pace) const {
  if (!is_uploading()) return nullptr;
  const std::uint64_t all = upload_->header.encoded_bytes(), received = all - std::min(all, upload_->payload.missing());
  const double all_at_once = static_cast<double>(all) / std::chrono::duration<double>(pace.most_time).count();
  const double rate = std::max(static_cast<double>(pace.least_rate), all_at_once);
  const std::chrono::duration<double> time_of_received(static_cast<double>(received) / rate);
  const bool too_slow =
      now - last_chunk_ >= pace.between_chunks || now - upload_began_ >= pace.grace + time_of_received;
  return too_slow ? upload_ : nullptr;
}

bool SessionProtocol::next(v1::SegmentStreamResponse& message, std::optional<FinishedFrame>& sent) {
  message.Clear();
  if (must_send_opened_) {
    must_send_opened_ = false;
    v1::StreamOpened& opened = *message.mutable_opened() = greeting_;
    opened.mutable_credit()->set_frames(credit_.frames);
    opened.mutable_credit()->set_bytes(credit_.bytes);
    return true;
  }
  if (must_send_draining_ && open_ && !outbox_.within_result()) {
    message.mutable_draining()->set_reason(*must_send_draining_);
    must_send_draining_.reset();
    return true;
  }
  if (!outbox_.next(message, sent)) return false;
  if (sent) {
    used_.frames -= 1;
    used_.bytes -= sent->credit_bytes;
  }
  return true;
}

}  // namespace segserve::server
