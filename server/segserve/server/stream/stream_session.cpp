#include "segserve/server/stream/stream_session.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "fmt/format.h"
#include "segserve/server/draining.hpp"
#include "segserve/server/frame.hpp"
#include "segserve/server/no_throw.hpp"
#include "segserve/wire/status.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using State = StreamFrame::State;

constexpr std::chrono::milliseconds kRetryOpen{1000};

absl::Status violation(std::string_view what) {
  return wire::with_reason(absl::InvalidArgumentError(fmt::format("protocol of the stream: {}", what)),
                           v1alpha1::ERROR_REASON_PROTOCOL_VIOLATION);
}

absl::Status no_credit_left() {
  return wire::with_details(
      absl::ResourceExhaustedError("all credit of this server is given to other streams; try again later"),
      {.reason = v1alpha1::ERROR_REASON_QUEUE_FULL, .retry_delay = kRetryOpen});
}

/// One line for the log. What clients chose is escaped, so that it cannot forge lines.
void log_frame(const std::string& client, const v1alpha1::FrameOutcome& outcome) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  spdlog::debug("frame {} of '{}', id '{}': {}, {}, {} points, {} segments, total {:.1f} ms", outcome.sequence(),
                absl::CHexEscape(client), absl::CHexEscape(outcome.request_id()),
                v1alpha1::OutcomeKind_Name(outcome.kind()), absl::CHexEscape(outcome.status().message()),
                outcome.result().summary().points(), outcome.result().summary().segments(),
                outcome.result().summary().timings().total_ms());
}

}  // namespace

StreamSession::StreamSession(const StreamSettings& settings, FrameExecutor& executor, CreditBudget& budget,
                             std::function<void()> wake)
    : settings_(settings), executor_(executor), budget_(budget), wake_(std::move(wake)) {}

void StreamSession::on_message(v1alpha1::SegmentStreamRequest& message) {
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
      finish(upload_, v1alpha1::OUTCOME_KIND_FAILED,
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
      if (frame->expiry && now >= *frame->expiry && frame->state < State::kRunning) expired.push_back(frame);
    }
    for (const FramePointer& frame : expired) stop(frame, v1alpha1::OUTCOME_KIND_EXPIRED);
    if (upload_ && upload_->state == State::kUploading && now - upload_->last_chunk >= settings_.upload_timeout) {
      finish(upload_, v1alpha1::OUTCOME_KIND_FAILED,
             wire::with_reason(absl::DeadlineExceededError(fmt::format("no chunk of the frame came for {} ms",
                                                                       settings_.upload_timeout.count())),
                               v1alpha1::ERROR_REASON_UPLOAD_STALLED));
    }
  }
  wake_();
}

absl::Status StreamSession::handle(v1alpha1::SegmentStreamRequest& message) {
  using Kind = v1alpha1::SegmentStreamRequest::KindCase;
  if (open_ == message.has_open()) {
    return violation(open_ ? "a second StreamOpen" : "the first message must be a StreamOpen");
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
  return violation("a message of no kind that this server knows");
}

absl::Status StreamSession::open(const v1alpha1::StreamOpen& message) {
  absl::StatusOr<wire::ParsedRequest> parsed = wire::parse_open(message, settings_.defaults);
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

absl::Status StreamSession::begin_frame(v1alpha1::FrameHeader& header) {
  const std::uint64_t sequence = header.sequence();
  if (has_sequence_ && sequence <= last_sequence_) {
    return violation(fmt::format("frame {} comes after frame {}", sequence, last_sequence_));
  }
  if (upload_ && upload_->state == State::kUploading) {
    return violation(fmt::format("frame {} begins with {} bytes of frame {} missing", sequence,
                                 upload_->payload.missing(), last_sequence_));
  }
  if (absl::Status status = take_credit(header); !status.ok()) return status;
  has_sequence_ = true;
  last_sequence_ = sequence;

  const auto frame = std::make_shared<StreamFrame>(std::move(header), settings_.now());
  frames_.emplace(sequence, frame);
  upload_ = frame;
  absl::Status status = draining_ ? draining() : prepare(*frame, defaults_, settings_.defaults, settings_.limits);
  if (!status.ok()) {
    finish(frame, v1alpha1::OUTCOME_KIND_FAILED, status);
    return absl::OkStatus();
  }
  frame->parsed.options.threads = std::min(frame->parsed.options.threads, settings_.max_threads);
  if (frame->payload.missing() == 0) uploaded(frame);
  return absl::OkStatus();
}

absl::Status StreamSession::take_credit(const v1alpha1::FrameHeader& header) {
  const Credit& all = credit_.credit();
  if (used_.frames == all.frames) {
    return violation(fmt::format("frame {} is beyond the credit of {} frames", header.sequence(), all.frames));
  }
  if (header.encoded_bytes() > all.bytes - used_.bytes) {
    return violation(fmt::format("frame {} of {} bytes is beyond the credit of {} bytes, of which {} are left",
                                 header.sequence(), header.encoded_bytes(), all.bytes, all.bytes - used_.bytes));
  }
  used_.frames += 1;
  used_.bytes += header.encoded_bytes();
  return absl::OkStatus();
}

absl::Status StreamSession::take_chunk(const v1alpha1::FrameChunk& chunk) {
  if (!upload_ || chunk.sequence() != last_sequence_) {
    return violation(fmt::format("a chunk of frame {}, which is not the last that has begun", chunk.sequence()));
  }
  if (chunk.data().empty() || chunk.data().size() > wire::kMaxChunkBytes) {
    return violation(
        fmt::format("a chunk of {} bytes; allowed are 1 to {}", chunk.data().size(), wire::kMaxChunkBytes));
  }
  const FramePointer frame = upload_;
  if (frame->state == State::kDone) return absl::OkStatus();  // was on its way when the frame ended
  if (!frame->payload.add(chunk.data())) {
    return violation(fmt::format("more bytes of frame {} than its header announced, {}", chunk.sequence(),
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
  stop(frame, v1alpha1::OUTCOME_KIND_CANCELLED);
}

void StreamSession::uploaded(const FramePointer& frame) {
  absl::Status status = attach_payload(*frame);
  if (status.ok()) status = submit(frame);
  if (!status.ok()) finish(frame, v1alpha1::OUTCOME_KIND_FAILED, status);
}

absl::Status StreamSession::submit(const FramePointer& frame) {
  frame->state = State::kQueued;
  while (true) {
    FrameJob job{
        .priority = frame->header.priority(),
        .points = std::max(frame->header.points(),
                           std::uint64_t{frame->header.cloud().width()} * frame->header.cloud().height()),
        .bytes = frame->header.encoded_bytes(),
        .may_exceed_queue =
            when_behind_ == v1alpha1::WHEN_BEHIND_UNSPECIFIED || when_behind_ == v1alpha1::WHEN_BEHIND_BLOCK,
        .run = [self = shared_from_this(), frame](SegmenterInterface& segmenter) { self->run(frame, segmenter); }};
    absl::StatusOr<FrameExecutor::Ticket> ticket = executor_.submit(std::move(job));
    if (ticket.ok()) {
      frame->ticket = *ticket;
      return absl::OkStatus();
    }
    if (when_behind_ != v1alpha1::WHEN_BEHIND_DROP_OLDEST) return ticket.status();
    if (!drop_oldest()) {  // the frames of other streams fill the queue
      finish(frame, v1alpha1::OUTCOME_KIND_DROPPED, absl::OkStatus());
      return absl::OkStatus();
    }
  }
}

bool StreamSession::drop_oldest() {
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued && sequence != last_sequence_ && executor_.withdraw(frame->ticket)) {
      finish(FramePointer(frame), v1alpha1::OUTCOME_KIND_DROPPED, absl::OkStatus());
      return true;
    }
  }
  return false;
}

void StreamSession::stop(const FramePointer& frame, v1alpha1::OutcomeKind kind) {
  const bool waits =
      frame->state == State::kUploading || (frame->state == State::kQueued && executor_.withdraw(frame->ticket));
  if (waits) {
    finish(frame, kind, absl::OkStatus());
  } else {
    frame->why_stopped = kind;
    frame->stopped = true;
  }
}

void StreamSession::finish(const FramePointer& frame, v1alpha1::OutcomeKind kind, const absl::Status& status) {
  finish(frame, without_result(*frame, kind, status));
}

void StreamSession::finish(const FramePointer& frame, FinishedFrame finished) {
  log_frame(client_name_, finished.outcome);
  frame->state = State::kDone;
  frame->finished = std::move(finished);
  frame->header.clear_cloud();
  frame->payload = {};
  if (order_ != v1alpha1::RESULT_ORDER_UNORDERED) {
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

void StreamSession::run(const FramePointer& frame, SegmenterInterface& segmenter) {
  {
    const std::lock_guard lock(mutex_);
    if (frame->state == State::kDone) return;
    frame->state = State::kRunning;
    ++running_;
  }
  const StopToken stop(&frame->stopped, frame->expiry);
  absl::StatusOr<v1alpha1::SegmentationResult> result = no_throw([&] {
    return process({frame->header.cloud(), frame->parsed, frame->arrival}, settings_.limits, segmenter, stop);
  });
  const absl::Status status = result.status();
  FinishedFrame finished = result.ok() ? with_result(*frame, *std::move(result))
                                       : without_result(*frame, v1alpha1::OUTCOME_KIND_FAILED, status);
  {
    const std::lock_guard lock(mutex_);
    --running_;
    const bool expired = frame->expiry && settings_.now() >= *frame->expiry;
    if (end_) {
      frame->state = State::kDone;
    } else if (frame->stopped) {
      finish(frame, frame->why_stopped, absl::OkStatus());
    } else if (expired) {
      finish(frame, v1alpha1::OUTCOME_KIND_EXPIRED, absl::OkStatus());
    } else {
      finish(frame, std::move(finished));
    }
  }
  wake_();
}

bool StreamSession::next(v1alpha1::SegmentStreamResponse& message) {
  const std::lock_guard lock(mutex_);
  message.Clear();
  if (end_) return false;
  if (must_send_opened_) {
    must_send_opened_ = false;
    *message.mutable_opened() = settings_.opened;
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
