// What the application and time do to a stream; what connections do is in stream_core_links.cpp.
#include "client/stream/stream_core.hpp"

#include <algorithm>
#include <utility>

#include "fmt/format.h"

namespace segserve::client {

StreamCore::StreamCore(StreamOptions options, std::vector<std::string> addresses, std::size_t first_address,
                       std::uint32_t seed)
    : options_(std::move(options)),
      addresses_(std::move(addresses)),
      book_(addresses_.size(), first_address, options_.retry, seed),
      random_(seed) {}

std::size_t StreamCore::waiting() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(frames_, [&](const auto& entry) { return waits(entry.second); }));
}

std::size_t StreamCore::unfinished() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(frames_, [](const auto& entry) { return entry.second.state != State::kDone; }));
}

/// Results that nobody took count, so that memory stays bounded.
std::size_t StreamCore::occupied() const {
  return static_cast<std::size_t>(std::ranges::count_if(frames_, [](const auto& entry) {
    const Frame& frame = entry.second;
    const bool has_result = frame.state == State::kDone && frame.raw.outcome.kind == OutcomeKind::kResult;
    return frame.state == State::kSent || frame.state == State::kLocal || has_result;
  }));
}

StreamCore::Admission StreamCore::admission() const {
  if (closed_ || finished_sending_ || !fatal_.ok()) return Admission::kRefused;
  if (waiting() < options_.max_waiting || options_.when_behind == WhenBehind::kDropOldest) return Admission::kOpen;
  return options_.when_behind == WhenBehind::kReject ? Admission::kRefused : Admission::kWait;
}

std::uint64_t StreamCore::accept(Payload payload, FrameOptions options, Time now) {
  if (waiting() >= options_.max_waiting) {  // kDropOldest: see admission()
    const auto oldest = std::ranges::find_if(frames_, [&](const auto& entry) { return waits(entry.second); });
    end_frame(oldest->second, OutcomeKind::kDropped, absl::ResourceExhaustedError("a newer frame came"), now);
  }
  Frame frame;
  frame.sequence = ++last_sequence_;
  frame.payload = std::move(payload);
  frame.captured = std::min(options.captured.value_or(now), now);
  frame.deadline = now + options.timeout.value_or(options_.frame_timeout);
  frame.ready_at = now;
  if (options.time_to_live) frame.expires = frame.captured + *options.time_to_live;
  Outcome& outcome = frame.raw.outcome;
  outcome.sequence = frame.sequence;
  outcome.request_id = options.request_id;
  outcome.frame_id = options.frame_id;
  outcome.stamp = options.stamp;
  outcome.report.handed_over = now;
  frame.raw.outputs = options.outputs.value_or(options_.outputs);
  frame.options = std::move(options);
  frames_.emplace(frame.sequence, std::move(frame));
  return last_sequence_;
}

StreamCore::Frame* StreamCore::find(std::uint64_t sequence) {
  const auto found = frames_.find(sequence);
  return found == frames_.end() ? nullptr : &found->second;
}

void StreamCore::cancel(std::uint64_t sequence, Time now) {
  Frame* frame = find(sequence);
  if (frame == nullptr || frame->state == State::kDone) return;
  frame->cancelled = true;
  if (frame->state == State::kSent) {
    links_.at(frame->connection).protocol.cancel(sequence);
  } else {
    end_frame(*frame, OutcomeKind::kCancelled, absl::CancelledError("cancelled"), now);
  }
}

void StreamCore::close(Time now) {
  closed_ = true;
  for (auto& [sequence, frame] : frames_) {
    if (frame.state != State::kDone) {
      end_frame(frame, OutcomeKind::kCancelled, absl::CancelledError("the stream was closed"), now);
    }
  }
}

void StreamCore::end_frame(Frame& frame, OutcomeKind kind, absl::Status status, Time now) {
  frame.state = State::kDone;
  frame.raw.outcome.kind = kind;
  frame.raw.outcome.status = std::move(status);
  frame.raw.outcome.report.outcome_done = now;
  if (frame.raw.outcome.report.outcome_begun == Time{}) frame.raw.outcome.report.outcome_begun = now;
  if (kind == OutcomeKind::kResult) {
    frame.raw.payload = frame.payload;
  }
  frame.payload = {};
  done_.push_back(frame.sequence);
}

/// Sends a frame once more, unless it was sent too often or is not wanted any more.
void StreamCore::again(Frame& frame, absl::Status error, Time ready_at, Time now) {
  if (frame.cancelled) return end_frame(frame, OutcomeKind::kCancelled, absl::CancelledError("cancelled"), now);
  const bool busy = absl::IsResourceExhausted(error);  // waits, however long that takes
  if (frame.raw.outcome.report.attempts >= options_.retry.max_attempts && !busy) {
    return end_frame(frame, OutcomeKind::kFailed, std::move(error), now);
  }
  frame.state = State::kWaiting;
  frame.ready_at = ready_at;
  frame.last_error = std::move(error);
}

bool StreamCore::has_outcome() const {
  if (options_.order == Order::kDone) return !done_.empty();
  return !frames_.empty() && frames_.begin()->second.state == State::kDone;
}

std::optional<RawOutcome> StreamCore::take_outcome() {
  if (!has_outcome()) return std::nullopt;
  const auto frame = options_.order == Order::kDone ? frames_.find(done_.front()) : frames_.begin();
  RawOutcome raw = std::move(frame->second.raw);
  std::erase(done_, frame->first);
  frames_.erase(frame);
  return raw;
}

void StreamCore::check_frames(Time now) {
  const bool hopeless = out_of_reach() && !options_.wait_for_server && !options_.fallback_to_local;
  for (auto& [sequence, frame] : frames_) {
    if (frame.state == State::kDone) continue;
    if (waits(frame) && frame.expires && *frame.expires <= now) {
      end_frame(frame, OutcomeKind::kExpired, absl::DeadlineExceededError("its time to live was over"), now);
    } else if (frame.deadline <= now) {
      const absl::Status& why = frame.last_error.ok() ? last_error_ : frame.last_error;
      std::string message = waits(frame) ? "the frame waited until its time was over" : "no answer in time";
      if (!why.ok()) message += fmt::format("; the last error was: {}", std::string(why.message()));
      if (frame.state == State::kSent) links_.at(frame.connection).protocol.cancel(sequence);
      end_frame(frame, OutcomeKind::kFailed, absl::DeadlineExceededError(message), now);
    } else if (waits(frame) && hopeless) {
      end_frame(frame, OutcomeKind::kFailed, last_error_, now);
    }
  }
}

StreamCore::Tick StreamCore::tick(Time now) {
  Tick tick{.actions = {}, .wake_at = now + std::chrono::hours(1)};
  check_frames(now);
  check_links(now, tick);
  open_link(now, tick);
  tick.actions = std::exchange(actions_, {});
  for (const auto& [sequence, frame] : frames_) {
    if (frame.state == State::kDone) continue;
    tick.wake_at = std::min(tick.wake_at, frame.deadline);
    if (!waits(frame)) continue;
    if (frame.expires) tick.wake_at = std::min(tick.wake_at, *frame.expires);
    if (frame.ready_at > now) tick.wake_at = std::min(tick.wake_at, frame.ready_at);
  }
  return tick;
}

std::optional<StreamCore::LocalJob> StreamCore::take_local_job(Time now) {
  if (!options_.fallback_to_local || !out_of_reach() || closed_) return std::nullopt;
  Frame* frame = pick(now);
  if (frame == nullptr) return std::nullopt;
  frame->state = State::kLocal;
  ++frame->raw.outcome.report.attempts;
  return LocalJob{frame->sequence, frame->payload, frame->options.options.value_or(options_.options),
                  frame->raw.outputs, frame->deadline};
}

void StreamCore::on_local_result(std::uint64_t sequence, absl::StatusOr<Result> result, Time now) {
  Frame* frame = find(sequence);
  if (frame == nullptr || frame->state != State::kLocal) return;  // cancelled or too late
  frame->raw.outcome.report.local = true;
  if (!result.ok()) return end_frame(*frame, OutcomeKind::kFailed, result.status(), now);
  frame->raw.outcome.result = *std::move(result);
  end_frame(*frame, OutcomeKind::kResult, absl::OkStatus(), now);
}

}  // namespace segserve::client
