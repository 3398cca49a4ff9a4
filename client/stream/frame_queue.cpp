// SPDX-License-Identifier: Apache-2.0
#include "client/stream/frame_queue.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "client/stream/stream_message.hpp"
#include "fmt/format.h"

namespace segserve::client {
namespace {

using State = QueuedFrame::State;

bool is_unfinished(const QueuedFrame& frame) { return frame.state != State::kDone; }

bool is_waiting(const QueuedFrame& frame) { return frame.state == State::kWaiting; }

/// Whether the frame takes a place in the window. Results that nobody has taken do, which bounds the memory in use.
bool is_in_flight(const QueuedFrame& frame) {
  const bool has_result = frame.state == State::kDone && frame.undecoded.outcome.kind == OutcomeKind::kResult;
  return frame.state == State::kSent || frame.state == State::kLocal || has_result;
}

template <typename Frames, typename Predicate>
std::size_t count(const Frames& frames, Predicate predicate) {
  const auto matches = [&](const auto& entry) { return predicate(entry.second); };
  return static_cast<std::size_t>(std::ranges::count_if(frames, matches));
}

absl::Status too_late(const QueuedFrame& frame, const absl::Status& connection_error) {
  const absl::Status& cause = frame.last_error.ok() ? connection_error : frame.last_error;
  std::string message =
      is_waiting(frame) ? "the frame waited until it was too late to send it" : "no answer came in time";
  if (!cause.ok()) message += fmt::format("; the last error was: {}", std::string(cause.message()));
  return absl::DeadlineExceededError(message);
}

}  // namespace

Delivery* QueuedFrame::delivery_on(ConnectionId connection) {
  const auto found = std::ranges::find(deliveries, connection, &Delivery::connection);
  return found == deliveries.end() ? nullptr : &*found;
}

void QueuedFrame::report_on(const Delivery& delivery) {
  report().header_sent = delivery.header_sent;
  report().payload_sent = delivery.payload_sent;
  report().outcome_begun = delivery.outcome_begun;
  report().bytes_sent = delivery.bytes_sent;
}

void QueuedFrame::forget_delivery(ConnectionId connection) {
  std::erase_if(deliveries, [&](const Delivery& delivery) { return delivery.connection == connection; });
}

std::size_t FrameQueue::waiting() const { return count(frames_, is_waiting); }

std::size_t FrameQueue::unfinished() const { return count(frames_, is_unfinished); }

std::size_t FrameQueue::in_flight() const { return count(frames_, is_in_flight); }

std::uint64_t FrameQueue::accept(FrameRequest request, Time now) {
  if (waiting() >= options_.max_waiting) {
    const auto oldest = std::ranges::find_if(frames_, [](const auto& entry) { return is_waiting(entry.second); });
    end(oldest->second, OutcomeKind::kDropped, status_of(OutcomeKind::kDropped), now);
  }
  QueuedFrame frame;
  frame.sequence = ++last_sequence_;
  frame.deadline = now + request.timeout;
  frame.expires = request.expires();
  frame.ready_at = now;
  frame.undecoded.points = request.payload.points();
  frame.undecoded.outputs = request.outputs;
  frame.undecoded.wants_tracks = request.tracking.has_value();
  frame.report().handed_over = now;
  Outcome& outcome = frame.undecoded.outcome;
  outcome.sequence = frame.sequence;
  outcome.request_id = request.request_id;
  outcome.frame_id = request.frame_id;
  outcome.stamp = request.stamp;
  frame.request = std::move(request);
  frames_.emplace(frame.sequence, std::move(frame));
  return last_sequence_;
}

QueuedFrame* FrameQueue::find(std::uint64_t sequence) {
  const auto found = frames_.find(sequence);
  return found == frames_.end() ? nullptr : &found->second;
}

QueuedFrame* FrameQueue::next_in_chain(Time now) {
  const auto found = std::ranges::find_if(frames_, [](const auto& entry) { return is_unfinished(entry.second); });
  if (found == frames_.end()) return nullptr;
  QueuedFrame& frame = found->second;
  const bool ready = is_waiting(frame) && frame.ready_at <= now && frame.deadline > now;
  if (!ready || in_flight() >= options_.max_in_flight) return nullptr;
  frame.request.tracking->state = track_state_;
  return &frame;
}

QueuedFrame* FrameQueue::next_to_send(Time now) {
  if (options_.tracking) return next_in_chain(now);
  const bool full = in_flight() >= options_.max_in_flight;
  QueuedFrame* best = nullptr;
  for (auto& [sequence, frame] : frames_) {
    const bool ready = is_waiting(frame) && frame.ready_at <= now && frame.deadline > now;
    if (ready && (best == nullptr || frame.request.priority > best->request.priority)) best = &frame;
    // Results that came before their turn fill the window, but must not shut out the frame they wait for.
    const bool others_wait_for_it = options_.order == Order::kSent && is_unfinished(frame);
    if (full && others_wait_for_it) return ready ? &frame : nullptr;
  }
  return full ? nullptr : best;
}

std::vector<QueuedFrame*> FrameQueue::sent() {
  std::vector<QueuedFrame*> sent;
  for (auto& [sequence, frame] : frames_) {
    if (frame.state == State::kSent) sent.push_back(&frame);
  }
  return sent;
}

std::vector<QueuedFrame*> FrameQueue::sent_on(ConnectionId connection) {
  std::vector<QueuedFrame*> frames = sent();
  std::erase_if(frames, [&](QueuedFrame* frame) { return frame->delivery_on(connection) == nullptr; });
  return frames;
}

void FrameQueue::end(QueuedFrame& frame, OutcomeKind kind, absl::Status status, Time now) {
  frame.state = State::kDone;
  frame.deliveries.clear();
  ++ended_;
  frame.undecoded.outcome.kind = kind;
  frame.undecoded.outcome.status = std::move(status);
  frame.report().outcome_done = now;
  if (frame.report().outcome_begun == Time{}) frame.report().outcome_begun = now;
  frame.request.payload = {};  // which may hold a cloud that the application wants back
  done_.push_back(frame.sequence);
}

void FrameQueue::end_all(OutcomeKind kind, const absl::Status& status, Time now) {
  for (auto& [sequence, frame] : frames_) {
    if (is_unfinished(frame)) end(frame, kind, status, now);
  }
}

void FrameQueue::fail_waiting(const absl::Status& status, Time now) {
  for (auto& [sequence, frame] : frames_) {
    if (is_waiting(frame)) end(frame, OutcomeKind::kFailed, status, now);
  }
}

void FrameQueue::end_late(QueuedFrame& frame, const absl::Status& connection_error, Time now) {
  if (frame.can_expire()) return end(frame, OutcomeKind::kExpired, status_of(OutcomeKind::kExpired), now);
  end(frame, OutcomeKind::kFailed, too_late(frame, connection_error), now);
}

std::vector<std::pair<QueuedFrame*, std::vector<Delivery>>> FrameQueue::end_overdue(
    const absl::Status& connection_error, Time now) {
  std::vector<std::pair<QueuedFrame*, std::vector<Delivery>>> sent;
  for (auto& [sequence, frame] : frames_) {
    if (!is_unfinished(frame)) continue;
    if (is_waiting(frame) && frame.expires && *frame.expires <= now) {
      end(frame, OutcomeKind::kExpired, status_of(OutcomeKind::kExpired), now);
    } else if (frame.deadline <= now) {
      if (frame.state == State::kSent) sent.emplace_back(&frame, frame.deliveries);
      end(frame, OutcomeKind::kFailed, too_late(frame, connection_error), now);
    }
  }
  return sent;
}

void FrameQueue::send_again(QueuedFrame& frame, absl::Status error, Time ready_at, Time now) {
  if (frame.cancelled) return end(frame, OutcomeKind::kCancelled, status_of(OutcomeKind::kCancelled), now);
  const bool no_room = absl::IsResourceExhausted(error);  // the frame waits, however long that takes
  if (frame.report().attempts >= options_.retry.max_attempts && !no_room) {
    return end(frame, OutcomeKind::kFailed, std::move(error), now);
  }
  frame.state = State::kWaiting;
  frame.deliveries.clear();
  frame.ready_at = ready_at;
  frame.last_error = std::move(error);
}

std::optional<Time> FrameQueue::next_change(Time now) const {
  std::optional<Time> next;
  const auto at = [&next](Time time) { next = std::min(next.value_or(time), time); };
  for (const auto& [sequence, frame] : frames_) {
    if (!is_unfinished(frame)) continue;
    at(frame.deadline);
    if (!is_waiting(frame)) continue;
    if (frame.expires) at(*frame.expires);
    if (frame.ready_at > now) at(frame.ready_at);
  }
  return next;
}

bool FrameQueue::has_outcome() const {
  if (options_.order == Order::kDone) return !done_.empty();
  return !frames_.empty() && !is_unfinished(frames_.begin()->second);
}

std::optional<UndecodedOutcome> FrameQueue::take_outcome() {
  if (!has_outcome()) return std::nullopt;
  const auto frame = options_.order == Order::kDone ? frames_.find(done_.front()) : frames_.begin();
  UndecodedOutcome undecoded = std::move(frame->second.undecoded);
  std::erase(done_, frame->first);
  frames_.erase(frame);
  return undecoded;
}

}  // namespace segserve::client
