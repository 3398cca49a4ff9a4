// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_scheduler.hpp"

#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/escaping.h"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using State = StreamFrame::State;

/// Writes one line to the log. What clients chose is escaped, so that it cannot forge lines.
void log_frame(const std::string& client, const v1::FrameOutcome& outcome) {
  if (!spdlog::should_log(spdlog::level::debug)) return;
  spdlog::debug("frame {} of '{}', id '{}': {}, {}, {} points, {} segments, total {:.1f} ms", outcome.sequence(),
                absl::CHexEscape(client), absl::CHexEscape(outcome.request_id()), v1::OutcomeKind_Name(outcome.kind()),
                absl::CHexEscape(outcome.status().message()), outcome.result().summary().points(),
                outcome.result().summary().segments(), outcome.result().summary().timings().total_ms());
}

}  // namespace

void SessionScheduler::set_policy(const v1::StreamOpen& open) {
  client_name_ = open.client_name();
  order_ = open.order();
  when_behind_ = open.when_behind();
}

void SessionScheduler::add(const StreamFramePointer& frame) { frames_.emplace(frame->header.sequence(), frame); }

bool SessionScheduler::may_exceed_queue() const {
  return when_behind_ == v1::WHEN_BEHIND_UNSPECIFIED || when_behind_ == v1::WHEN_BEHIND_BLOCK;
}

void SessionScheduler::submit(const StreamFramePointer& frame, const Computation& compute) {
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
    if (when_behind_ != v1::WHEN_BEHIND_DROP_OLDEST) return fail(frame, ticket.status());
    const bool others_fill_the_queue = !drop_oldest(*frame);
    if (others_fill_the_queue) return finish(frame, v1::OUTCOME_KIND_DROPPED, absl::OkStatus());
  }
}

bool SessionScheduler::drop_oldest(const StreamFrame& newest) {
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued && frame.get() != &newest && executor_.withdraw(frame->ticket)) {
      finish(StreamFramePointer(frame), v1::OUTCOME_KIND_DROPPED, absl::OkStatus());
      return true;
    }
  }
  return false;
}

bool SessionScheduler::start(const StreamFramePointer& frame, Time now) {
  if (frame->state == State::kDone) return false;
  const FrameSettings& settings = frame->settings;
  if (frame->cancelled) {
    finish(frame, frame->why_cancelled, absl::OkStatus());
    return false;
  }
  if (settings.deadline && now + executor_.expected_time(settings.estimated_points) > *settings.deadline) {
    finish(frame, v1::OUTCOME_KIND_EXPIRED, absl::OkStatus());
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
  } else if (frame->cancelled) {
    finish(frame, frame->why_cancelled, absl::OkStatus());
  } else if (expired) {
    finish(frame, v1::OUTCOME_KIND_EXPIRED, absl::OkStatus());
  } else if (computed.ok()) {
    finish(frame, *std::move(computed));
  } else {
    fail(frame, computed.status());
  }
}

void SessionScheduler::fail(const StreamFramePointer& frame, const absl::Status& status) {
  finish(frame, v1::OUTCOME_KIND_FAILED, status);
}

void SessionScheduler::cancel(std::uint64_t sequence) {
  const auto found = frames_.find(sequence);
  if (found == frames_.end() || found->second->state == State::kDone) return;
  stop(StreamFramePointer(found->second), v1::OUTCOME_KIND_CANCELLED);
}

void SessionScheduler::expire(Time now) {
  std::vector<StreamFramePointer> expired;
  for (const auto& [sequence, frame] : frames_) {
    const bool waits = frame->state == State::kUploading || frame->state == State::kQueued;
    if (waits && frame->settings.deadline && now >= *frame->settings.deadline) expired.push_back(frame);
  }
  for (const StreamFramePointer& frame : expired) stop(frame, v1::OUTCOME_KIND_EXPIRED);
}

void SessionScheduler::abandon_all() {
  abandoned_ = true;
  for (const auto& [sequence, frame] : frames_) {
    if (frame->state == State::kQueued) executor_.withdraw(frame->ticket);
    // A worker that has just taken the job, but not started it, leaves the frame alone.
    if (frame->state != State::kRunning) frame->state = State::kDone;
    frame->cancelled = true;
  }
  frames_.clear();
}

void SessionScheduler::stop(const StreamFramePointer& frame, v1::OutcomeKind kind) {
  const bool waits =
      frame->state == State::kUploading || (frame->state == State::kQueued && executor_.withdraw(frame->ticket));
  if (waits) {
    finish(frame, kind, absl::OkStatus());
  } else {
    frame->why_cancelled = kind;
    frame->cancelled = true;
  }
}

void SessionScheduler::finish(const StreamFramePointer& frame, v1::OutcomeKind kind, const absl::Status& status) {
  finish(frame, outcome_without_result(*frame, kind, status));
}

void SessionScheduler::finish(const StreamFramePointer& frame, FinishedFrame finished) {
  log_frame(client_name_, finished.outcome);
  frame->state = State::kDone;
  frame->finished = std::move(finished);
  frame->header.clear_cloud();
  frame->payload = {};
  frame->memory = {};
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
