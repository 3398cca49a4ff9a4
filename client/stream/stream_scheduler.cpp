// SPDX-License-Identifier: Apache-2.0
#include "client/stream/stream_scheduler.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/fleet/retry.hpp"
#include "client/stream/stream_message.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::client {

using State = QueuedFrame::State;

namespace {

constexpr const char* kOutageKey = "segserve.client/outage";

}  // namespace

bool is_outage(const absl::Status& status) { return status.GetPayload(kOutageKey).has_value(); }

StreamScheduler::StreamScheduler(StreamOptions options, std::uint32_t seed)
    : options_(std::move(options)),
      frames_(options_),
      links_(options_, seed),
      dispatch_(options_, frames_, links_, seed),
      random_(seed) {}

void StreamScheduler::set_servers(const ServerList& list) {
  links_.set_servers(list);
  dispatch_.set_servers(list.servers);
}

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
  for (const Delivery& delivery : frame->deliveries) {
    if (ServerLink* link = links_.find(delivery.connection)) link->protocol.cancel(sequence);
  }
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
  for (const auto& [frame, deliveries] : frames_.end_overdue(links_.last_error(), now)) {
    cancel_deliveries(frame->sequence, deliveries, now);
  }
  const bool may_wait = options_.wait_for_server || options_.fallback_to_local;
  if (links_.out_of_reach() && !may_wait) frames_.fail_waiting(links_.last_error(), now);
  if (closed_) {
    links_.break_all();
  } else {
    if (finished_sending_ && frames_.unfinished() == 0) links_.end_all();
    wake_no_later_than(links_.check_silence([&](ServerId server) { return dispatch_.usual_time(server, now); }, now));
    wake_no_later_than(check_outage(now));
    const bool needs_server = fatal_.ok() && (!finished_sending_ || frames_.waiting() > 0);
    if (needs_server) wake_no_later_than(links_.open_missing(now));
  }
  wake_no_later_than(frames_.next_change(now));
  wake_no_later_than(dispatch_.next_change(now));
  return {.actions = links_.take_actions(), .wake_at = wake_at, .trouble = links_.take_trouble()};
}

std::optional<Time> StreamScheduler::check_outage(Time now) {
  const bool may_end = options_.longest_outage.count() > 0 && !options_.fallback_to_local && fatal_.ok();
  if (!may_end || !links_.out_of_reach() || !frames_.sent().empty()) {
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

bool StreamScheduler::next_message(ConnectionId id, OutgoingMessage& outgoing, Time now) {
  ServerLink* link = links_.find(id);
  if (link == nullptr) return false;
  if (link->takes_frames() && link->protocol.has_turn()) dispatch_.begin_frame(*link, now);
  const auto sent = link->protocol.next(outgoing);
  if (!sent) return false;
  QueuedFrame* frame = sent->sequence ? frames_.find(*sent->sequence) : nullptr;
  Delivery* delivery = frame == nullptr ? nullptr : frame->delivery_on(id);
  if (delivery != nullptr) {
    delivery->bytes_sent += byte_size(outgoing);
    if (outgoing.message.has_frame()) delivery->header_sent = now;
    if (sent->completes_payload) delivery->payload_sent = now;
    frame->report_on(*delivery);
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
    case StreamProtocol::Event::kTokenOver:  // the next tick makes a stream with the token of that time
      return;
    case StreamProtocol::Event::kOld:
      return links_.on_old(link);
    case StreamProtocol::Event::kBegun:
      return on_begun(link, event.sequence, now);
    case StreamProtocol::Event::kOutcome:
      return on_outcome(link, event, now);
  }
}

void StreamScheduler::on_begun(const ServerLink& link, std::uint64_t sequence, Time now) {
  QueuedFrame* frame = frames_.find(sequence);
  Delivery* delivery = frame == nullptr ? nullptr : frame->delivery_on(link.id);
  if (delivery != nullptr) delivery->outcome_begun = now;
}

void StreamScheduler::on_outcome(ServerLink& link, StreamProtocol::Event& event, Time now) {
  QueuedFrame* frame = frames_.find(event.sequence);
  const Delivery* found = frame == nullptr ? nullptr : frame->delivery_on(link.id);
  if (found == nullptr) return;  // the frame has ended here before
  const Delivery delivery = *found;
  link.has_answered = true;
  frame->forget_delivery(link.id);
  const std::vector<Delivery> others = frame->deliveries;
  frame->report_on(delivery);
  frame->report().bytes_received = link.outcome_bytes;
  frame->report().address = link.server.address;
  const OutcomeKind kind = from_message(event.outcome.kind());
  if (kind == OutcomeKind::kResult) dispatch_.on_answered(link.server.id, delivery, now);
  if (kind == OutcomeKind::kExpired) dispatch_.on_too_late(link.server.id, delivery, now);
  on_answer(link, *frame, event, now);
  if (frame->state == State::kDone) cancel_deliveries(event.sequence, others, now);
}

void StreamScheduler::on_answer(ServerLink& link, QueuedFrame& frame, StreamProtocol::Event& event, Time now) {
  const OutcomeKind kind = from_message(event.outcome.kind());
  if (kind == OutcomeKind::kFailed)
    return on_failed_frame(link, frame, wire::from_message(event.outcome.status()), now);
  if (!event.intact) {
    const absl::Status error =
        wire::with_reason(absl::AbortedError("the bytes of the result do not have the checksum that was announced"),
                          wire::ErrorReason::kChecksum);
    const Time again = dispatch_.on_failed(link, frame, error, std::chrono::milliseconds(0), now);
    if (is_left_to_another(frame, error)) return;
    return frames_.send_again(frame, error, again, now);
  }
  if (kind != OutcomeKind::kResult && is_left_to_another(frame, status_of(kind))) return;
  if (kind == OutcomeKind::kExpired) return frames_.end_late(frame, links_.last_error(), now);
  if (kind == OutcomeKind::kResult) {
    frame.undecoded.message = std::move(*event.outcome.mutable_result());
    frames_.keep_track_state(frame.undecoded.message.tracking().state());
  }
  frames_.end(frame, kind, status_of(kind), now);
}

bool StreamScheduler::is_left_to_another(QueuedFrame& frame, const absl::Status& error) {
  if (frame.deliveries.empty() || frame.cancelled) return false;
  frame.last_error = error;
  return true;
}

void StreamScheduler::on_failed_frame(ServerLink& link, QueuedFrame& frame, const absl::Status& status, Time now) {
  absl::Status error = unavailable_if_cancelled(status);
  if (error.ok()) error = absl::InternalError("the server failed the frame and did not say why");
  // The time of the stream's token is over. The next stream may have a newer one; if not, that stream fails.
  if (absl::IsUnauthenticated(error) && link.protocol.ending()) {
    if (!is_left_to_another(frame, error)) frames_.send_again(frame, error, now, now);
    return;
  }
  const auto asked_for = wire::details_of(error).retry_delay;
  const auto wait = backoff(options_.retry, frame.report().attempts, asked_for, random_);
  const Time again = dispatch_.on_failed(link, frame, error, wait, now);
  if (is_retryable(error) && is_left_to_another(frame, error)) {
    frame.ready_at = now + wait;
    return;
  }
  const bool rejected = absl::IsResourceExhausted(error) && options_.when_behind == WhenBehind::kReject;
  if (rejected || !is_retryable(error)) return frames_.end(frame, OutcomeKind::kFailed, error, now);
  frames_.send_again(frame, error, again, now);
}

void StreamScheduler::cancel_deliveries(std::uint64_t sequence, const std::vector<Delivery>& deliveries, Time now) {
  for (const Delivery& delivery : deliveries) {
    ServerLink* link = links_.find(delivery.connection);
    if (link == nullptr) continue;
    link->protocol.cancel(sequence);
    dispatch_.on_too_late(link->server.id, delivery, now);
  }
}

void StreamScheduler::on_closed(ConnectionId id, const absl::Status& status, Time now) {
  const auto end = links_.on_closed(id, status, now);
  if (!end) return;
  if (end->fatal) {
    fatal_ = end->why;
    return frames_.end_all(OutcomeKind::kFailed, fatal_, now);
  }
  dispatch_.on_lost(end->server, end->useless, now);
  for (QueuedFrame* frame : frames_.sent_on(id)) {
    frame->forget_delivery(id);
    frame->failed_at.insert(end->server);
    if (!is_left_to_another(*frame, end->why)) frames_.send_again(*frame, end->why, now, now);
  }
}

std::optional<StreamScheduler::LocalJob> StreamScheduler::take_local_job(Time now) {
  if (!options_.fallback_to_local || !links_.out_of_reach() || closed_) return std::nullopt;
  QueuedFrame* frame = frames_.next_to_send(now);
  if (frame == nullptr) return std::nullopt;
  frame->state = State::kLocal;
  ++frame->report().attempts;
  const FrameRequest& request = frame->request;
  return LocalJob{frame->sequence, request.payload,  request.options, request.outputs,
                  request.prompts, request.tracking, frame->deadline};
}

void StreamScheduler::on_local_result(std::uint64_t sequence, absl::StatusOr<Result> result, Time now) {
  QueuedFrame* frame = frames_.find(sequence);
  if (frame == nullptr || frame->state != State::kLocal) return;  // cancelled, or too late
  frame->report().local = true;
  if (!result.ok()) return frames_.end(*frame, OutcomeKind::kFailed, result.status(), now);
  if (result->tracks) frames_.keep_track_state(result->tracks->state);
  frame->undecoded.outcome.result = *std::move(result);
  frames_.end(*frame, OutcomeKind::kResult, absl::OkStatus(), now);
}

}  // namespace segserve::client
