// SPDX-License-Identifier: Apache-2.0
#include "client/stream/stream_scheduler.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/calls/retry.hpp"
#include "client/stream/stream_message.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::client {

using State = QueuedFrame::State;

namespace {

constexpr const char* kOutageKey = "segserve.client/outage";

}  // namespace

bool is_outage(const absl::Status& status) { return status.GetPayload(kOutageKey).has_value(); }

StreamScheduler::StreamScheduler(StreamOptions options, std::vector<std::string> addresses, std::size_t first_address,
                                 std::uint32_t seed)
    : options_(std::move(options)),
      frames_(options_),
      links_(options_, std::move(addresses), first_address, seed),
      random_(seed) {}

StreamScheduler::Admission StreamScheduler::admission() const {
  if (closed_ || finished_sending_ || !fatal_.ok()) return Admission::kRefused;
  const bool has_room = frames_.waiting() < options_.max_waiting;
  if (has_room || options_.when_behind == WhenBehind::kDropOldest) return Admission::kOpen;
  return options_.when_behind == WhenBehind::kReject ? Admission::kRefused : Admission::kWait;
}

absl::Status StreamScheduler::refusal() const {
  if (!fatal_.ok()) return fatal_;
  if (closed_ || finished_sending_) {
    return absl::FailedPreconditionError("the stream takes no more frames: finish() was called");
  }
  return absl::ResourceExhaustedError(fmt::format("{} frames wait already", options_.max_waiting));
}

std::uint64_t StreamScheduler::accept(FrameRequest request, Time now) {
  return frames_.accept(std::move(request), now);
}

void StreamScheduler::cancel(std::uint64_t sequence, Time now) {
  QueuedFrame* frame = frames_.find(sequence);
  if (frame == nullptr || frame->state == State::kDone) return;
  if (frame->state != State::kSent) {
    return frames_.end(*frame, OutcomeKind::kCancelled, status_of(OutcomeKind::kCancelled), now);
  }
  frame->cancelled = true;
  if (ServerLink* link = links_.find(frame->connection)) link->protocol.cancel(sequence);
}

void StreamScheduler::close(Time now) {
  closed_ = true;
  frames_.end_all(OutcomeKind::kCancelled, absl::CancelledError("the stream was closed"), now);
}

StreamScheduler::Tick StreamScheduler::tick(Time now) {
  Time wake_at = now + std::chrono::hours(1);
  const auto wake_no_later_than = [&wake_at](std::optional<Time> time) {
    wake_at = std::min(wake_at, time.value_or(wake_at));
  };
  for (QueuedFrame* frame : frames_.end_overdue(links_.last_error(), now)) {
    service_time_.add_at_least(now - frame->sent_at);
    if (ServerLink* link = links_.find(frame->connection)) link->protocol.cancel(frame->sequence);
  }
  const bool may_wait = options_.wait_for_server || options_.fallback_to_local;
  if (links_.out_of_reach() && !may_wait) frames_.fail_waiting(links_.last_error(), now);
  if (closed_) {
    links_.break_all();
  } else {
    if (finished_sending_ && frames_.unfinished() == 0) links_.end_all();
    wake_no_later_than(links_.check_silence(now));
    wake_no_later_than(check_outage(now));
    const bool needs_server = fatal_.ok() && (!finished_sending_ || frames_.waiting() > 0);
    if (needs_server) wake_no_later_than(links_.open_if_needed(now));
  }
  wake_no_later_than(frames_.next_change(now));
  return {.actions = links_.take_actions(), .wake_at = wake_at};
}

std::optional<Time> StreamScheduler::check_outage(Time now) {
  const bool may_end = options_.longest_outage.count() > 0 && !options_.fallback_to_local && fatal_.ok();
  if (!may_end || !links_.out_of_reach() || frames_.sent() > 0) {
    outage_began_.reset();
    return std::nullopt;
  }
  if (!outage_began_) outage_began_ = now;
  const Time end = *outage_began_ + options_.longest_outage;
  if (now < end) return end;
  const double seconds = std::chrono::duration<double>(options_.longest_outage).count();
  fatal_ = absl::UnavailableError(
      fmt::format("no server has been in reach for {:g} s ({})", seconds, std::string(links_.last_error().message())));
  fatal_.SetPayload(kOutageKey, absl::Cord());
  frames_.end_all(OutcomeKind::kFailed, fatal_, now);
  return std::nullopt;
}

QueuedFrame* StreamScheduler::next_in_time(Time now) {
  while (QueuedFrame* frame = frames_.next_to_send(now)) {
    const bool others_wait = frames_.waiting() > 1;
    // Without any frame under way, nothing would tell that the server is faster again.
    const bool is_late = now + service_time_.bound() > frame->useful_until() && frames_.sent() > 0;
    if (!others_wait || !is_late) return frame;
    frames_.end_late(*frame, links_.last_error(), now);
  }
  return nullptr;
}

/// Starts to send the next frame, if there is one and the credit has room for it.
void StreamScheduler::begin_frame(ServerLink& link, Time now) {
  QueuedFrame* frame = next_in_time(now);
  if (frame == nullptr) return;
  const std::uint64_t bytes = frame->request.payload.bytes();
  switch (link.protocol.fit(bytes)) {
    case StreamProtocol::Fit::kLater:
      return;  // smaller frames must not overtake it for ever
    case StreamProtocol::Fit::kNever:
      return frames_.end(
          *frame, OutcomeKind::kFailed,
          wire::limit_exceeded("the frame has", bytes, "bytes", "credit.bytes", link.protocol.credit_bytes()), now);
    case StreamProtocol::Fit::kNow:
      break;
  }
  if (link.protocol.in_flight() == 0) link.last_sign_of_life = now;  // an idle server is silent with good reason
  frame->state = State::kSent;
  frame->connection = link.id;
  frame->sent_at = now;
  FrameReport& report = frame->report();
  ++report.attempts;
  report.bytes_sent = report.bytes_received = 0;
  link.protocol.begin(frame->sequence, header_message(frame->request, options_, frame->useful_until(), now),
                      frame->request.payload);
}

bool StreamScheduler::next_message(ConnectionId id, OutgoingMessage& outgoing, Time now) {
  ServerLink* link = links_.find(id);
  if (link == nullptr) return false;
  if (link->protocol.has_turn()) begin_frame(*link, now);
  const auto sent = link->protocol.next(outgoing);
  if (!sent) return false;
  QueuedFrame* frame = sent->sequence ? frames_.find(*sent->sequence) : nullptr;
  if (frame != nullptr && frame->connection == id) {
    FrameReport& report = frame->report();
    report.bytes_sent += byte_size(outgoing);
    if (outgoing.message.has_frame()) report.header_sent = now;
    if (sent->completes_payload) report.payload_sent = now;
  }
  return true;
}

bool StreamScheduler::wants_half_close(ConnectionId id) {
  const ServerLink* link = links_.find(id);
  return link != nullptr && link->protocol.wants_half_close();
}

bool StreamScheduler::on_message(ConnectionId id, v1::SegmentStreamResponse& message, Time now) {
  ServerLink* link = links_.find(id);
  if (link == nullptr) return false;
  links_.on_sign_of_life(id, now);
  if (message.has_outcome()) link->outcome_bytes = 0;
  link->outcome_bytes += message.ByteSizeLong();
  auto event = link->protocol.receive(message);
  if (!event.ok()) {
    links_.break_link(*link, LinkAction::kBreak, event.status(), now);
    return true;
  }
  on_event(*link, *event, now);
  return event->kind != StreamProtocol::Event::kNothing && event->kind != StreamProtocol::Event::kBegun;
}

void StreamScheduler::on_event(ServerLink& link, StreamProtocol::Event& event, Time now) {
  switch (event.kind) {
    case StreamProtocol::Event::kNothing:
      return;
    case StreamProtocol::Event::kOpened:
      return links_.on_opened(link);
    case StreamProtocol::Event::kDraining:
      return links_.on_draining(link, now);
    case StreamProtocol::Event::kBegun:
      if (QueuedFrame* frame = frames_.find(event.sequence)) frame->report().outcome_begun = now;
      return;
    case StreamProtocol::Event::kOutcome:
      return on_outcome(link, event, now);
  }
}

void StreamScheduler::on_outcome(ServerLink& link, StreamProtocol::Event& event, Time now) {
  QueuedFrame* frame = frames_.find(event.sequence);
  const bool awaited = frame != nullptr && frame->state == State::kSent && frame->connection == link.id;
  if (!awaited) return;  // the frame has ended here before
  frame->report().bytes_received = link.outcome_bytes;
  frame->report().address = links_.address_of(link);
  const OutcomeKind kind = from_message(event.outcome.kind());
  if (kind == OutcomeKind::kResult) service_time_.add(now - frame->sent_at);
  if (kind == OutcomeKind::kExpired) service_time_.add_at_least(now - frame->sent_at);
  if (kind == OutcomeKind::kExpired) return frames_.end_late(*frame, links_.last_error(), now);
  if (kind == OutcomeKind::kFailed) return on_failed_frame(*frame, wire::from_message(event.outcome.status()), now);
  if (!event.intact) {
    const absl::Status error =
        wire::with_reason(absl::AbortedError("the bytes of the result do not have the checksum that was announced"),
                          wire::ErrorReason::kChecksum);
    return frames_.send_again(*frame, error, now, now);
  }
  if (kind == OutcomeKind::kResult) frame->undecoded.message = std::move(*event.outcome.mutable_result());
  frames_.end(*frame, kind, status_of(kind), now);
}

void StreamScheduler::on_failed_frame(QueuedFrame& frame, const absl::Status& status, Time now) {
  absl::Status error = unavailable_if_cancelled(status);
  if (error.ok()) error = absl::InternalError("the server failed the frame and did not say why");
  const bool rejected = absl::IsResourceExhausted(error) && options_.when_behind == WhenBehind::kReject;
  if (rejected || !is_retryable(error)) return frames_.end(frame, OutcomeKind::kFailed, error, now);
  const auto asked_for = wire::details_of(error).retry_delay;
  const auto wait = backoff(options_.retry, frame.report().attempts, asked_for, random_);
  frames_.send_again(frame, error, now + wait, now);
}

void StreamScheduler::on_closed(ConnectionId id, const absl::Status& status, Time now) {
  const auto end = links_.on_closed(id, status, now);
  if (!end) return;
  if (end->fatal) {
    fatal_ = end->why;
    return frames_.end_all(OutcomeKind::kFailed, fatal_, now);
  }
  for (QueuedFrame* frame : frames_.sent_on(id)) frames_.send_again(*frame, end->why, now, now);
}

std::optional<StreamScheduler::LocalJob> StreamScheduler::take_local_job(Time now) {
  if (!options_.fallback_to_local || !links_.out_of_reach() || closed_) return std::nullopt;
  QueuedFrame* frame = frames_.next_to_send(now);
  if (frame == nullptr) return std::nullopt;
  frame->state = State::kLocal;
  ++frame->report().attempts;
  const FrameRequest& request = frame->request;
  return LocalJob{frame->sequence, request.payload, request.options, request.outputs, frame->deadline};
}

void StreamScheduler::on_local_result(std::uint64_t sequence, absl::StatusOr<Result> result, Time now) {
  QueuedFrame* frame = frames_.find(sequence);
  if (frame == nullptr || frame->state != State::kLocal) return;  // cancelled, or too late
  frame->report().local = true;
  if (!result.ok()) return frames_.end(*frame, OutcomeKind::kFailed, result.status(), now);
  frame->undecoded.outcome.result = *std::move(result);
  frames_.end(*frame, OutcomeKind::kResult, absl::OkStatus(), now);
}

}  // namespace segserve::client
