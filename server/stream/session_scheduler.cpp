// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_scheduler.hpp"

#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::server {
namespace {

using State = StreamFrame::State;

}  // namespace

void SessionScheduler::set_policy(const v1::StreamOpen& open) {
  order_ = open.order();
  when_behind_ = open.when_behind();
}

void SessionScheduler::add(const StreamFramePointer& frame) { frames_.emplace(frame->header.sequence(), frame); }

bool SessionScheduler::may_exceed_queue() const {
  return when_behind_ == v1::WHEN_BEHIND_UNSPECIFIED || when_behind_ == v1::WHEN_BEHIND_BLOCK;
}

void SessionScheduler::submit(const StreamFramePointer& frame, const Computation& compute, Time now) {
  frame->record.queued = now;
  frame->state = State::kQueued;
  while (true) {
    const absl::StatusOr<FrameExecutor::Ticket> ticket = executor_.submit({.priority = frame->header.priority(),
                                                                           .points = frame->settings.estimated_points,
                                                                           .bytes = frame->header.encoded_bytes(),
                                                                           .may_exceed_queue = may_exceed_queue(),
                                                                           .run = compute});
    if (ticket.ok()) {
      frame->ticket = *ticket;
      return;
    }
    if (when_behind_ != v1::WHEN_BEHIND_DROP_OLDEST) return fail(frame, ticket.status(), now);
    const bool others_fill_the_queue = !drop_oldest(*frame, now);
    if (others_fill_the_queue) return finish(frame, v1::OUTCOME_KIND_DROPPED, absl::OkStatus(), now);
  }
}

bool SessionScheduler::drop_oldest(const StreamFrame& newest, Time now) {
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued && frame.get() != &newest && executor_.withdraw(frame->ticket)) {
      finish(StreamFramePointer(frame), v1::OUTCOME_KIND_DROPPED, absl::OkStatus(), now);
      return true;
    }
  }
  return false;
}

bool SessionScheduler::start(const StreamFramePointer& frame, Time now) {
  if (frame->state == State::kDone) return false;
  const FrameSettings& settings = frame->settings;
  if (frame->cancelled) {
    finish(frame, frame->why_cancelled, absl::OkStatus(), now);
    return false;
  }
  if (settings.deadline && now + executor_.expected_time(settings.estimated_points) > *settings.deadline) {
    finish(frame, v1::OUTCOME_KIND_EXPIRED, absl::OkStatus(), now);
    return false;
  }
  frame->state = State::kRunning;
  ++running_;
  return true;
}

void SessionScheduler::complete(const StreamFramePointer& frame, absl::StatusOr<FinishedFrame> computed, Time now) {
  --running_;
  const bool expired = frame->settings.deadline && now >= *frame->settings.deadline;
  if (abandoned_) {
    frame->state = State::kDone;
    abandon(*frame, now);
  } else if (frame->cancelled) {
    finish(frame, frame->why_cancelled, absl::OkStatus(), now);
  } else if (expired) {
    finish(frame, v1::OUTCOME_KIND_EXPIRED, absl::OkStatus(), now);
  } else if (computed.ok()) {
    finish(frame, *std::move(computed), absl::OkStatus(), now);
  } else {
    fail(frame, computed.status(), now);
  }
}

void SessionScheduler::fail(const StreamFramePointer& frame, const absl::Status& status, Time now) {
  finish(frame, v1::OUTCOME_KIND_FAILED, status, now);
}

void SessionScheduler::cancel(std::uint64_t sequence, Time now) {
  const auto found = frames_.find(sequence);
  if (found == frames_.end() || found->second->state == State::kDone) return;
  stop(StreamFramePointer(found->second), v1::OUTCOME_KIND_CANCELLED, now);
}

void SessionScheduler::expire(Time now) {
  std::vector<StreamFramePointer> expired;
  for (const auto& [sequence, frame] : frames_) {
    const bool waits = frame->state == State::kUploading || frame->state == State::kQueued;
    if (waits && frame->settings.deadline && now >= *frame->settings.deadline) expired.push_back(frame);
  }
  for (const StreamFramePointer& frame : expired) stop(frame, v1::OUTCOME_KIND_EXPIRED, now);
}

void SessionScheduler::abandon_all(const absl::Status& why, Time now) {
  abandoned_ = why;
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued) executor_.withdraw(frame->ticket);
    frame->cancelled = true;
    if (frame->state == State::kRunning) continue;  // `complete` does the rest
    // A worker that has just taken the job, but not started it, leaves the frame alone.
    frame->state = State::kDone;
    abandon(*frame, now);
  }
  frames_.clear();
}

void SessionScheduler::abandon(StreamFrame& frame, Time now) {
  FrameRecord& record = frame.finished ? frame.finished->record : frame.record;
  end_with_stream(record, *abandoned_, now);
  observers_.on_frame(record);
}

void SessionScheduler::stop(const StreamFramePointer& frame, v1::OutcomeKind kind, Time now) {
  const bool waits =
      frame->state == State::kUploading || (frame->state == State::kQueued && executor_.withdraw(frame->ticket));
  if (waits) {
    finish(frame, kind, absl::OkStatus(), now);
  } else {
    frame->why_cancelled = kind;
    frame->cancelled = true;
  }
}

void SessionScheduler::finish(const StreamFramePointer& frame, v1::OutcomeKind kind, const absl::Status& status,
                              Time now) {
  finish(frame, outcome_without_result(*frame, kind, status), status, now);
}

void SessionScheduler::finish(const StreamFramePointer& frame, FinishedFrame finished, const absl::Status& status,
                              Time now) {
  frame->record.outcome = finished.outcome.kind();
  frame->record.status = facts_of(status);
  frame->record.decided = now;
  frame->state = State::kDone;
  frame->finished = std::move(finished);
  frame->finished->record = std::move(frame->record);
  frame->header.clear_cloud();
  frame->payload = {};
  frame->memory = {};
  if (frame->finished->record.status.reason == wire::ErrorReason::kQueueFull) frame->quota.refund();
  frame->quota = {};
  if (order_ != v1::RESULT_ORDER_UNORDERED) {
    send_in_order();
  } else {
    outbox_.push(*std::move(frame->finished));
    frames_.erase(frame->header.sequence());
  }
}

void SessionScheduler::send_in_order() {
  while (!frames_.empty() && frames_.begin()->second->finished) {
    outbox_.push(*std::move(frames_.begin()->second->finished));
    frames_.erase(frames_.begin());
  }
}

}  // namespace segserve::server
