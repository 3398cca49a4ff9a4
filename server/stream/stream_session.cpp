#include "server/stream/stream_session.hpp"

#include <utility>
#include <vector>

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"
#include "server/scheduling/refusals.hpp"
#include "server/stream/protocol_violation.hpp"

namespace segserve::server {
namespace {

using State = StreamFrame::State;

}  // namespace

StreamSession::StreamSession(const StreamSettings& settings, FrameExecutor& executor, CreditBudget& budget,
                             std::function<void()> wake)
    : settings_(settings), executor_(executor), budget_(budget), wake_(std::move(wake)) {}

void StreamSession::on_message(v1::SegmentStreamRequest& message) {
  {
    const std::lock_guard lock(mutex_);
    if (end_) return;
    if (const absl::Status status = handle(message); !status.ok()) end_with(status);
  }
  wake_();
}

void StreamSession::on_half_close() {
  {
    const std::lock_guard lock(mutex_);
    half_closed_ = true;
    if (upload_ && upload_->state == State::kUploading) {
      finish(upload_, v1::OUTCOME_KIND_FAILED,
             wire::malformed(fmt::format("the stream was closed with {} of {} bytes of the frame missing",
                                         upload_->payload.missing(), upload_->header.encoded_bytes())));
    }
  }
  wake_();
}

void StreamSession::on_cancel(const absl::Status& why) {
  {
    const std::lock_guard lock(mutex_);
    end_with(why);
  }
  wake_();
}

void StreamSession::start_draining() {
  {
    const std::lock_guard lock(mutex_);
    if (draining_) return;
    draining_ = must_send_draining_ = true;
  }
  wake_();
}

void StreamSession::on_tick() {
  {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = settings_.now();
    std::vector<FramePointer> expired;
    for (const auto& [sequence, frame] : frames_) {
      if (frame->settings.deadline && now >= *frame->settings.deadline && frame->state < State::kRunning)
        expired.push_back(frame);
    }
    for (const FramePointer& frame : expired) stop(frame, v1::OUTCOME_KIND_EXPIRED);
    if (upload_ && upload_->state == State::kUploading && now - upload_->last_chunk >= settings_.upload_timeout) {
      finish(upload_, v1::OUTCOME_KIND_FAILED,
             wire::with_reason(absl::DeadlineExceededError(fmt::format("no chunk of the frame came for {} ms",
                                                                       settings_.upload_timeout.count())),
                               v1::ERROR_REASON_UPLOAD_STALLED));
    }
  }
  wake_();
}

absl::Status StreamSession::handle(v1::SegmentStreamRequest& message) {
  using Kind = v1::SegmentStreamRequest::KindCase;
  if (open_ == message.has_open()) {
    return protocol_violation(open_ ? "a second StreamOpen" : "the first message must be a StreamOpen");
  }
  switch (message.kind_case()) {
    case Kind::kOpen:
      return open(message.open());
    case Kind::kFrame:
      return begin_frame(*message.mutable_frame());
    case Kind::kChunk:
      return take_chunk(message.chunk());
    case Kind::kCancel:
      cancel_frame(message.cancel().sequence());
      return absl::OkStatus();
    case Kind::KIND_NOT_SET:
      break;
  }
  return protocol_violation("a message of no kind that this server knows");
}

absl::Status StreamSession::open(const v1::StreamOpen& message) {
  absl::StatusOr<wire::ParsedRequest> parsed = settings_.resolver.resolve_stream(message);
  if (!parsed.ok()) return parsed.status();
  if (draining_) return draining();
  auto reservation = budget_.reserve({message.wanted().frames(), message.wanted().bytes()});
  if (!reservation) return no_credit_left();
  credit_ = *std::move(reservation);
  defaults_ = *std::move(parsed);
  order_ = message.order();
  when_behind_ = message.when_behind();
  client_name_ = message.client_name();
  open_ = must_send_opened_ = true;
  return absl::OkStatus();
}

void StreamSession::end_with(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued) executor_.withdraw(frame->ticket);
    if (frame->state != State::kRunning) frame->state = State::kDone;  // a worker that just took it lets it be
    frame->stopped = true;
  }
  frames_.clear();
  upload_.reset();
  outbox_.clear();
}

bool StreamSession::next(v1::SegmentStreamResponse& message) {
  const std::lock_guard lock(mutex_);
  message.Clear();
  if (end_) return false;
  if (must_send_opened_) {
    must_send_opened_ = false;
    *message.mutable_opened() = settings_.greeting;
    message.mutable_opened()->mutable_credit()->set_frames(credit_.credit().frames);
    message.mutable_opened()->mutable_credit()->set_bytes(credit_.credit().bytes);
    return true;
  }
  if (must_send_draining_ && open_) {
    must_send_draining_ = false;
    message.mutable_draining();
    return true;
  }
  std::optional<std::uint64_t> returned;
  if (!outbox_.next(message, returned)) return false;
  if (returned) {
    used_.frames -= 1;
    used_.bytes -= *returned;
  }
  return true;
}

std::optional<absl::Status> StreamSession::ended() const {
  const std::lock_guard lock(mutex_);
  if (running_ > 0) return std::nullopt;
  if (end_) return end_;
  const bool nothing_left = frames_.empty() && outbox_.empty() && !must_send_opened_;
  if (!nothing_left) return std::nullopt;
  if (half_closed_) return absl::OkStatus();
  if (draining_) return draining();
  return std::nullopt;
}

void StreamSession::close() {
  const std::lock_guard lock(mutex_);
  credit_.release();
}

std::size_t StreamSession::frames_in_flight() const {
  const std::lock_guard lock(mutex_);
  return frames_.size();
}

}  // namespace segserve::server
