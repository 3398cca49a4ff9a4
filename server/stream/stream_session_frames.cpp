// The frames of a stream, from their header to their outcome.
#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/payload_blocks.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/frame_computation.hpp"
#include "server/scheduling/refusals.hpp"
#include "server/stream/protocol_violation.hpp"
#include "server/stream/stream_session.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using State = StreamFrame::State;

/// One line for the log. What clients chose is escaped, so that it cannot forge lines.
void log_frame(const std::string& client, const v1::FrameOutcome& outcome) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  spdlog::debug("frame {} of '{}', id '{}': {}, {}, {} points, {} segments, total {:.1f} ms", outcome.sequence(),
                absl::CHexEscape(client), absl::CHexEscape(outcome.request_id()), v1::OutcomeKind_Name(outcome.kind()),
                absl::CHexEscape(outcome.status().message()), outcome.result().summary().points(),
                outcome.result().summary().segments(), outcome.result().summary().timings().total_ms());
}

}  // namespace

absl::Status StreamSession::begin_frame(v1::FrameHeader& header) {
  const std::uint64_t sequence = header.sequence();
  if (has_sequence_ && sequence <= last_sequence_) {
    return protocol_violation(fmt::format("frame {} comes after frame {}", sequence, last_sequence_));
  }
  if (upload_ && upload_->state == State::kUploading) {
    return protocol_violation(fmt::format("frame {} begins with {} bytes of frame {} missing", sequence,
                                          upload_->payload.missing(), last_sequence_));
  }
  if (absl::Status status = take_credit(header); !status.ok()) return status;
  has_sequence_ = true;
  last_sequence_ = sequence;

  const auto frame = std::make_shared<StreamFrame>(std::move(header), settings_.now());
  frames_.emplace(sequence, frame);
  upload_ = frame;
  absl::Status status = draining_ ? draining() : resolve(*frame);
  if (!status.ok()) {
    finish(frame, v1::OUTCOME_KIND_FAILED, status);
    return absl::OkStatus();
  }
  if (frame->payload.missing() == 0) uploaded(frame);
  return absl::OkStatus();
}

absl::Status StreamSession::resolve(StreamFrame& frame) {
  ASSIGN_OR_RETURN(frame.settings, settings_.resolver.resolve_frame(frame.header, defaults_, settings_.now()));
  frame.payload = wire::IncomingBytes(wire::payload_block_sizes(frame.header.cloud()));
  return absl::OkStatus();
}

absl::Status StreamSession::take_credit(const v1::FrameHeader& header) {
  const Credit& all = credit_.credit();
  if (used_.frames == all.frames) {
    return protocol_violation(fmt::format("frame {} is beyond the credit of {} frames", header.sequence(), all.frames));
  }
  if (header.encoded_bytes() > all.bytes - used_.bytes) {
    return protocol_violation(fmt::format("frame {} of {} bytes is beyond the credit of {} bytes, of which {} are left",
                                          header.sequence(), header.encoded_bytes(), all.bytes,
                                          all.bytes - used_.bytes));
  }
  used_.frames += 1;
  used_.bytes += header.encoded_bytes();
  return absl::OkStatus();
}

absl::Status StreamSession::take_chunk(const v1::FrameChunk& chunk) {
  if (!upload_ || chunk.sequence() != last_sequence_) {
    return protocol_violation(
        fmt::format("a chunk of frame {}, which is not the last that has begun", chunk.sequence()));
  }
  if (chunk.data().empty() || chunk.data().size() > wire::kMaxChunkBytes) {
    return protocol_violation(
        fmt::format("a chunk of {} bytes; allowed are 1 to {}", chunk.data().size(), wire::kMaxChunkBytes));
  }
  const FramePointer frame = upload_;
  if (frame->state == State::kDone) return absl::OkStatus();  // was on its way when the frame ended
  if (!frame->payload.add(chunk.data())) {
    return protocol_violation(fmt::format("more bytes of frame {} than its header announced, {}", chunk.sequence(),
                                          frame->header.encoded_bytes()));
  }
  frame->last_chunk = settings_.now();
  if (frame->payload.missing() == 0) uploaded(frame);
  return absl::OkStatus();
}

void StreamSession::cancel_frame(std::uint64_t sequence) {
  const auto found = frames_.find(sequence);
  if (found == frames_.end() || found->second->state == State::kDone) return;
  const FramePointer frame = found->second;
  stop(frame, v1::OUTCOME_KIND_CANCELLED);
}

void StreamSession::uploaded(const FramePointer& frame) {
  absl::Status status = attach_payload(*frame);
  if (status.ok()) status = submit(frame);
  if (!status.ok()) finish(frame, v1::OUTCOME_KIND_FAILED, status);
}

absl::Status StreamSession::submit(const FramePointer& frame) {
  frame->state = State::kQueued;
  while (true) {
    FrameJob job{
        .priority = frame->header.priority(),
        .points = frame->settings.estimated_points,
        .bytes = frame->header.encoded_bytes(),
        .may_exceed_queue = when_behind_ == v1::WHEN_BEHIND_UNSPECIFIED || when_behind_ == v1::WHEN_BEHIND_BLOCK,
        .run = [self = shared_from_this(), frame](SegmentationBackend& segmenter) { self->run(frame, segmenter); }};
    absl::StatusOr<FrameExecutor::Ticket> ticket = executor_.submit(std::move(job));
    if (ticket.ok()) {
      frame->ticket = *ticket;
      return absl::OkStatus();
    }
    if (when_behind_ != v1::WHEN_BEHIND_DROP_OLDEST) return ticket.status();
    if (!drop_oldest()) {  // the frames of other streams fill the queue
      finish(frame, v1::OUTCOME_KIND_DROPPED, absl::OkStatus());
      return absl::OkStatus();
    }
  }
}

bool StreamSession::drop_oldest() {
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued && sequence != last_sequence_ && executor_.withdraw(frame->ticket)) {
      finish(FramePointer(frame), v1::OUTCOME_KIND_DROPPED, absl::OkStatus());
      return true;
    }
  }
  return false;
}

void StreamSession::stop(const FramePointer& frame, v1::OutcomeKind kind) {
  const bool waits =
      frame->state == State::kUploading || (frame->state == State::kQueued && executor_.withdraw(frame->ticket));
  if (waits) {
    finish(frame, kind, absl::OkStatus());
  } else {
    frame->why_stopped = kind;
    frame->stopped = true;
  }
}

void StreamSession::finish(const FramePointer& frame, v1::OutcomeKind kind, const absl::Status& status) {
  finish(frame, without_result(*frame, kind, status));
}

void StreamSession::finish(const FramePointer& frame, FinishedFrame finished) {
  log_frame(client_name_, finished.outcome);
  frame->state = State::kDone;
  frame->finished = std::move(finished);
  frame->header.clear_cloud();
  frame->payload = {};
  if (order_ != v1::RESULT_ORDER_UNORDERED) {
    send_in_order();
  } else {
    outbox_.push(*std::move(frame->finished));
    frames_.erase(frame->header.sequence());
  }
}

void StreamSession::send_in_order() {
  while (!frames_.empty() && frames_.begin()->second->finished) {
    outbox_.push(*std::move(frames_.begin()->second->finished));
    frames_.erase(frames_.begin());
  }
}

void StreamSession::run(const FramePointer& frame, SegmentationBackend& segmenter) {
  {
    const std::lock_guard lock(mutex_);
    if (frame->state == State::kDone) return;
    frame->state = State::kRunning;
    ++running_;
  }
  absl::StatusOr<v1::SegmentationResult> result = catch_exceptions(
      [&] { return compute_frame(frame->header.cloud(), frame->settings, frame->stopped, segmenter); });
  const absl::Status status = result.status();
  FinishedFrame finished =
      result.ok() ? with_result(*frame, *std::move(result)) : without_result(*frame, v1::OUTCOME_KIND_FAILED, status);
  {
    const std::lock_guard lock(mutex_);
    --running_;
    const bool expired = frame->settings.deadline && settings_.now() >= *frame->settings.deadline;
    if (end_) {
      frame->state = State::kDone;
    } else if (frame->stopped) {
      finish(frame, frame->why_stopped, absl::OkStatus());
    } else if (expired) {
      finish(frame, v1::OUTCOME_KIND_EXPIRED, absl::OkStatus());
    } else {
      finish(frame, std::move(finished));
    }
  }
  wake_();
}

}  // namespace segserve::server
