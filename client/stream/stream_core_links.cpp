// What connections do to a stream, and what it does with them.
#include <algorithm>
#include <utility>

#include "client/calls/retry.hpp"
#include "client/calls/serialise.hpp"
#include "client/stream/stream_core.hpp"
#include "fmt/format.h"
#include "proto/wire/options_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::client {
namespace {

template <typename Duration>
google::protobuf::Duration to_message(Duration duration) {
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
  google::protobuf::Duration message;
  message.set_seconds(nanoseconds / 1'000'000'000);
  message.set_nanos(static_cast<std::int32_t>(nanoseconds % 1'000'000'000));
  return message;
}

google::protobuf::Timestamp to_message(std::chrono::system_clock::time_point time) {
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  const auto seconds = std::chrono::floor<std::chrono::seconds>(nanoseconds);
  google::protobuf::Timestamp message;
  message.set_seconds(seconds.count());
  message.set_nanos(static_cast<std::int32_t>((nanoseconds - seconds).count()));
  return message;
}

v1::WhenBehind to_message(WhenBehind when) {
  switch (when) {
    case WhenBehind::kDropOldest:
      return v1::WHEN_BEHIND_DROP_OLDEST;
    case WhenBehind::kReject:
      return v1::WHEN_BEHIND_REJECT;
    case WhenBehind::kBlock:
      return v1::WHEN_BEHIND_BLOCK;
  }
  return v1::WHEN_BEHIND_BLOCK;
}

OutcomeKind from_message(v1::OutcomeKind kind) {
  switch (kind) {
    case v1::OUTCOME_KIND_RESULT:
      return OutcomeKind::kResult;
    case v1::OUTCOME_KIND_DROPPED:
      return OutcomeKind::kDropped;
    case v1::OUTCOME_KIND_EXPIRED:
      return OutcomeKind::kExpired;
    case v1::OUTCOME_KIND_CANCELLED:
      return OutcomeKind::kCancelled;
    default:
      return OutcomeKind::kFailed;
  }
}

absl::Status status_of(OutcomeKind kind) {
  switch (kind) {
    case OutcomeKind::kDropped:
      return absl::ResourceExhaustedError("a newer frame came");
    case OutcomeKind::kExpired:
      return absl::DeadlineExceededError("its time to live was over");
    case OutcomeKind::kCancelled:
      return absl::CancelledError("cancelled");
    default:
      return absl::OkStatus();
  }
}

std::optional<std::chrono::milliseconds> retry_delay(const absl::Status& status) {
  return wire::details_of(status).retry_delay;
}

}  // namespace

v1::StreamOpen StreamCore::open_message(const StreamOptions& options) {
  v1::StreamOpen open;
  open.set_client_name(options.client_name);
  *open.mutable_options() = wire::to_message(options.options);
  *open.mutable_outputs() = wire::to_message(options.outputs);
  // A frame may be repeated, so only this side can keep the order in which frames were handed over.
  open.set_order(v1::RESULT_ORDER_UNORDERED);
  open.set_when_behind(to_message(options.when_behind));
  open.mutable_wanted()->set_frames(static_cast<std::uint32_t>(options.max_in_flight));
  open.mutable_wanted()->set_bytes(options.wanted_bytes);
  return open;
}

void StreamCore::open_link(Time now, Tick& tick) {
  const bool wanted = !closed_ && fatal_.ok() && (!finished_sending_ || waiting() > 0);
  const bool there_is_one = std::ranges::any_of(
      links_, [](const auto& entry) { return entry.second.broken.ok() && !entry.second.protocol.ending(); });
  if (!wanted || there_is_one) return;
  const AddressBook::Choice choice = book_.choose(now);
  if (choice.not_before > now) {
    tick.wake_at = std::min(tick.wake_at, choice.not_before);
    return;
  }
  const ConnectionId id = ++last_connection_;
  links_.emplace(id, Link{.protocol = Connection(open_message(options_)), .address = choice.address, .last_sign = now});
  actions_.push_back({Action::kOpen, id, choice.address});
  tick.wake_at = std::min(tick.wake_at, now + options_.progress_timeout / 2);
}

void StreamCore::break_link(ConnectionId id, Link& link, Action::Kind kind, absl::Status why, Time now) {
  link.broken = std::move(why);
  actions_.push_back({kind, id, link.address});
  if (closed_) return;
  last_error_ = link.broken;
  book_.failed(link.address, now, std::nullopt);
}

void StreamCore::check_links(Time now, Tick& tick) {
  const auto half = options_.progress_timeout / 2;
  for (auto& [id, link] : links_) {
    if (!link.broken.ok()) continue;
    if (closed_) {
      break_link(id, link, Action::kBreak, absl::CancelledError("the stream was closed"), now);
      continue;
    }
    if (finished_sending_ && unfinished() == 0) link.protocol.end();
    const bool owes_us = !link.protocol.opened() || link.protocol.in_flight() > 0 || link.protocol.ending();
    if (!owes_us) continue;
    if (link.probed_at && now >= *link.probed_at + half) {
      break_link(id, link, Action::kBreakSilent,
                 absl::UnavailableError(fmt::format("{} showed no sign of life for {} ms", addresses_[link.address],
                                                    options_.progress_timeout.count())),
                 now);
      continue;
    }
    if (!link.probed_at && now >= link.last_sign + half) {
      link.probed_at = now;
      actions_.push_back({Action::kProbe, id, link.address});
    }
    tick.wake_at = std::min(tick.wake_at, link.probed_at.value_or(link.last_sign) + half);
  }
}

/// The waiting frame that goes next, if the window has room for one.
StreamCore::Frame* StreamCore::pick(Time now) {
  const bool full = occupied() >= options_.max_in_flight;
  Frame* best = nullptr;
  for (auto& [sequence, frame] : frames_) {
    const bool ready = waits(frame) && frame.ready_at <= now && frame.deadline > now;
    if (ready && (best == nullptr || frame.options.priority > best->options.priority)) best = &frame;
    // Results that came before their turn fill the window, but must not shut out the one they wait for.
    const bool others_wait_for_it = options_.order == Order::kSent && frame.state != State::kDone;
    if (full && others_wait_for_it) return ready ? &frame : nullptr;
  }
  return full ? nullptr : best;
}

v1::FrameHeader StreamCore::header_of(const Frame& frame, Time now) const {
  v1::FrameHeader header;
  header.set_request_id(frame.options.request_id);
  header.set_frame_id(frame.options.frame_id);
  if (frame.options.stamp) *header.mutable_stamp() = to_message(*frame.options.stamp);
  if (frame.options.options) *header.mutable_options() = wire::to_message(*frame.options.options);
  if (frame.options.outputs) *header.mutable_outputs() = wire::to_message(*frame.options.outputs);
  if (frame.options.time_to_live) {
    *header.mutable_time_to_live() = to_message(*frame.options.time_to_live);
    *header.mutable_age() = to_message(now - frame.captured);
  }
  header.set_priority(frame.options.priority);
  return header;
}

void StreamCore::begin_frame(Link& link, ConnectionId id, Time now) {
  Frame* frame = pick(now);
  if (frame == nullptr) return;
  switch (link.protocol.fit(frame->payload.bytes())) {
    case Connection::Fit::kLater:
      return;  // smaller ones must not overtake it for ever
    case Connection::Fit::kNever:
      return end_frame(*frame, OutcomeKind::kFailed,
                       wire::limit_exceeded("the frame has", frame->payload.bytes(), "bytes", "credit.bytes",
                                            link.protocol.credit_bytes()),
                       now);
    case Connection::Fit::kNow:
      break;
  }
  if (link.protocol.in_flight() == 0) link.last_sign = now;  // it was silent with good reason
  frame->state = State::kSent;
  frame->connection = id;
  FrameReport& report = frame->raw.outcome.report;
  ++report.attempts;
  report.bytes_sent = report.bytes_received = 0;
  link.protocol.begin(frame->sequence, header_of(*frame, now), frame->payload);
}

bool StreamCore::next_message(ConnectionId id, Outgoing& outgoing, Time now) {
  const auto found = links_.find(id);
  if (found == links_.end() || !found->second.broken.ok()) return false;
  Link& link = found->second;
  if (link.protocol.has_turn()) begin_frame(link, id, now);
  const auto sent = link.protocol.next(outgoing);
  if (!sent) return false;
  Frame* frame = sent->sequence ? find(*sent->sequence) : nullptr;
  if (frame != nullptr && frame->connection == id) {
    FrameReport& report = frame->raw.outcome.report;
    report.bytes_sent += byte_size(outgoing);
    if (outgoing.message.has_frame()) report.header_sent = now;
    if (sent->completes_payload) report.payload_sent = now;
  }
  return true;
}

bool StreamCore::wants_half_close(ConnectionId id) const {
  const auto link = links_.find(id);
  return link != links_.end() && link->second.broken.ok() && link->second.protocol.wants_half_close();
}

void StreamCore::on_sign_of_life(ConnectionId id, Time now) {
  const auto link = links_.find(id);
  if (link == links_.end()) return;
  link->second.last_sign = now;
  link->second.probed_at.reset();
}

bool StreamCore::on_message(ConnectionId id, v1::SegmentStreamResponse& message, Time now) {
  const auto found = links_.find(id);
  if (found == links_.end() || !found->second.broken.ok()) return false;
  Link& link = found->second;
  on_sign_of_life(id, now);
  if (message.has_outcome()) link.outcome_bytes = 0;
  link.outcome_bytes += message.ByteSizeLong();
  auto event = link.protocol.receive(message);
  if (!event.ok()) {
    break_link(id, link, Action::kBreak, event.status(), now);
    return true;
  }
  switch (event->kind) {
    case Connection::Event::kNothing:
      return false;
    case Connection::Event::kOpened:
      book_.reached(link.address);
      return true;
    case Connection::Event::kDraining:
      book_.failed(link.address, now, std::nullopt);
      last_error_ = absl::UnavailableError(fmt::format("{} is about to stop", addresses_[link.address]));
      return true;
    case Connection::Event::kBegun:
      if (Frame* frame = find(event->sequence)) frame->raw.outcome.report.outcome_begun = now;
      return false;
    case Connection::Event::kOutcome:
      if (Frame* frame = find(event->sequence)) frame->raw.outcome.report.bytes_received = link.outcome_bytes;
      on_outcome(id, *event, now);
      return true;
  }
  return true;
}

void StreamCore::on_outcome(ConnectionId id, Connection::Event& event, Time now) {
  Frame* frame = find(event.sequence);
  const bool awaited = frame != nullptr && frame->state == State::kSent && frame->connection == id;
  if (!awaited) return;  // it ended here before
  frame->raw.outcome.report.address = addresses_[links_.at(id).address];
  const OutcomeKind kind = from_message(event.outcome.kind());
  if (kind == OutcomeKind::kFailed) return on_failed_frame(*frame, wire::from_message(event.outcome.status()), now);
  if (!event.intact) {
    const absl::Status error =
        wire::with_reason(absl::AbortedError("the bytes of the result do not have the checksum that was announced"),
                          v1::ERROR_REASON_CHECKSUM);
    return again(*frame, error, now, now);
  }
  if (kind == OutcomeKind::kResult) frame->raw.message = std::move(*event.outcome.mutable_result());
  end_frame(*frame, kind, status_of(kind), now);
}

void StreamCore::on_failed_frame(Frame& frame, const absl::Status& status, Time now) {
  const bool rejected = absl::IsResourceExhausted(status) && options_.when_behind == WhenBehind::kReject;
  const absl::Status error = as_seen_by_a_caller_who_did_not_cancel(status);
  if (error.ok()) {
    return end_frame(frame, OutcomeKind::kFailed,
                     absl::InternalError("the server failed the frame and did not say why"), now);
  }
  if (rejected || !is_retryable(error)) return end_frame(frame, OutcomeKind::kFailed, error, now);
  const auto wait = backoff(options_.retry, frame.raw.outcome.report.attempts, retry_delay(error), random_);
  again(frame, error, now + wait, now);
}

void StreamCore::on_closed(ConnectionId id, const absl::Status& status, Time now) {
  const auto found = links_.find(id);
  if (found == links_.end()) return;
  const Link link = std::move(found->second);
  links_.erase(found);
  absl::Status why = link.broken.ok() ? as_seen_by_a_caller_who_did_not_cancel(status) : link.broken;
  if (why.ok()) why = absl::UnavailableError(fmt::format("{} closed the stream", addresses_[link.address]));
  const bool expected = closed_ || !link.broken.ok() || (link.protocol.ending() && link.protocol.in_flight() == 0);
  if (!expected) {
    if (!is_worth_reconnecting(why)) return give_up(why, now);
    last_error_ = why;
    if (!link.protocol.ending()) book_.failed(link.address, now, retry_delay(why));
  }
  for (auto& [sequence, frame] : frames_) {
    if (frame.state == State::kSent && frame.connection == id) again(frame, why, now, now);
  }
}

void StreamCore::give_up(const absl::Status& status, Time now) {
  fatal_ = status;
  for (auto& [sequence, frame] : frames_) {
    if (frame.state != State::kDone) end_frame(frame, OutcomeKind::kFailed, status, now);
  }
}

}  // namespace segserve::client
