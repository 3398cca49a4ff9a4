// SPDX-License-Identifier: Apache-2.0
#include "client/stream/frame_dispatch.hpp"

#include <algorithm>
#include <chrono>

#include "client/stream/stream_message.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::client {

using State = QueuedFrame::State;
using Fit = StreamProtocol::Fit;

FrameDispatch::FrameDispatch(const StreamOptions& options, FrameQueue& frames, ServerLinks& links, std::uint32_t seed)
    : options_(options), frames_(frames), links_(links), random_(seed) {}

FrameDispatch::Record& FrameDispatch::record_of(ServerId server) {
  const auto [record, is_new] = records_.try_emplace(server);
  if (is_new) record->second.turn = random_();  // so that not all streams begin with the same server
  record->second.pace.set_one_of_several(links_.is_fleet());
  return record->second;
}

void FrameDispatch::set_servers(const std::vector<Server>& servers) {
  std::erase_if(records_, [&](const auto& record) {
    return std::ranges::find(servers, record.first, &Server::id) == servers.end();
  });
}

void FrameDispatch::begin_frame(ServerLink& link, Time now) {
  if (QueuedFrame* frame = frame_to_copy(link, now)) {
    if (copy_reason(*frame, now) == CopyReason::kLate) budget_.take_one();
    frame->report().hedged = true;
    return send(*frame, link, now);
  }
  QueuedFrame* frame = next_frame(link, now);
  if (frame == nullptr) return;
  const bool has_room = link.protocol.fit(frame->request.payload.bytes()) == Fit::kNow;
  if (!has_room) return;  // smaller frames must not overtake it for ever
  frame->state = State::kSent;
  budget_.on_frame();
  send(*frame, link, now);
}

QueuedFrame* FrameDispatch::next_frame(ServerLink& link, Time now) {
  while (QueuedFrame* frame = frames_.next_to_send(now)) {
    const auto choice = choose(*frame, now);
    if (!choice) {
      const auto error = wire::limit_exceeded("the frame has", frame->request.payload.bytes(), "bytes", "credit.bytes",
                                              link.protocol.credit_bytes());
      frames_.end(*frame, OutcomeKind::kFailed, error, now);
      return nullptr;
    }
    if (choice->connection != link.id) {
      constexpr std::chrono::milliseconds kSoon{5};
      const Time again = now + std::max<Clock::duration>(choice->reconsider_in.value_or(kSoon), kSoon);
      reconsider_at_ = std::min(reconsider_at_.value_or(again), again);
      return nullptr;
    }
    const bool others_wait = frames_.waiting() > 1;
    // Without any frame under way, nothing would tell that the server is faster again.
    const bool is_idle = links_.is_fleet() ? link.protocol.in_flight() == 0 : frames_.sent().empty();
    const bool is_too_late = now + record_of(link.server.id).pace.bound() > frame->useful_until() && !is_idle;
    if (!others_wait || !is_too_late) return frame;
    frames_.end_late(*frame, links_.last_error(), now);
  }
  return nullptr;
}

std::optional<PlaceChoice> FrameDispatch::choose(const QueuedFrame& frame, Time now) {
  const std::uint64_t bytes = frame.request.payload.bytes();
  std::vector<ServerLink*> links = links_.taking_frames();
  std::erase_if(links, [&](const ServerLink* link) {
    const bool has_it = std::ranges::find(frame.deliveries, link->id, &Delivery::connection) != frame.deliveries.end();
    return has_it || link->protocol.fit(bytes) == Fit::kNever;
  });
  if (links.empty()) return std::nullopt;
  if (std::ranges::all_of(links, [now](const ServerLink* link) { return link->rests(now); })) {
    const ServerLink* first = *std::ranges::min_element(links, {}, &ServerLink::rests_until);
    return PlaceChoice{0, *first->rests_until - now};
  }
  std::erase_if(links, [now](const ServerLink* link) { return link->rests(now); });
  links = untried(frame, links);
  if (links.size() == 1) return PlaceChoice{links.front()->id, std::nullopt};
  std::vector<FramePlace> places;
  places.reserve(links.size());
  for (const ServerLink* link : links) places.push_back(place_on(*link, bytes, now));
  return choose_place(places);
}

std::vector<ServerLink*> FrameDispatch::untried(const QueuedFrame& frame, const std::vector<ServerLink*>& links) {
  std::vector<ServerLink*> untried = links;
  std::erase_if(untried, [&](const ServerLink* link) { return frame.failed_at.contains(link->server.id); });
  return untried.empty() ? links : untried;
}

FramePlace FrameDispatch::place_on(const ServerLink& link, std::uint64_t bytes, Time now) {
  const Record& record = record_of(link.server.id);
  FramePlace place{.connection = link.id,
                   .in_flight = link.protocol.in_flight(),
                   .expected = record.pace.expected(now),
                   .turn = record.turn,
                   .has_room = link.protocol.has_turn() && link.protocol.fit(bytes) == Fit::kNow};
  for (QueuedFrame* frame : frames_.sent_on(link.id)) {
    const std::chrono::nanoseconds age = now - frame->delivery_on(link.id)->sent_at;
    place.oldest = std::max(place.oldest, age);
  }
  return place;
}

FrameDispatch::CopyReason FrameDispatch::copy_reason(QueuedFrame& frame, Time now) {
  const bool may_have_one = frame.deliveries.size() == 1 && !frame.cancelled && frame.ready_at <= now &&
                            now < frame.useful_until() && frame.report().attempts < options_.retry.max_attempts;
  if (!may_have_one) return CopyReason::kNone;
  const Delivery& delivery = frame.deliveries.front();
  const ServerLink* link = links_.find(delivery.connection);
  if (link != nullptr && link->silence.is_suspect()) return CopyReason::kSilent;
  const bool is_late = options_.hedge_after.count() > 0 && now >= delivery.sent_at + options_.hedge_after;
  return is_late && budget_.has_one() ? CopyReason::kLate : CopyReason::kNone;
}

QueuedFrame* FrameDispatch::frame_to_copy(const ServerLink& link, Time now) {
  if (!links_.is_fleet()) return nullptr;
  for (QueuedFrame* frame : frames_.sent()) {
    if (copy_reason(*frame, now) == CopyReason::kNone) continue;
    const auto choice = choose(*frame, now);
    const bool may_begin = link.protocol.fit(frame->request.payload.bytes()) == Fit::kNow;
    if (choice && choice->connection == link.id && may_begin) return frame;
  }
  return nullptr;
}

void FrameDispatch::send(QueuedFrame& frame, ServerLink& link, Time now) {
  if (link.protocol.in_flight() == 0) link.silence.on_sign_of_life(now);  // an idle server is silent with good reason
  record_of(link.server.id).turn = ++last_turn_;
  frame.deliveries.push_back({.connection = link.id, .sent_at = now});
  FrameReport& report = frame.report();
  ++report.attempts;
  report.bytes_sent = report.bytes_received = 0;
  link.protocol.begin(frame.sequence, header_message(frame.request, options_, frame.useful_until(), now),
                      frame.request.payload);
}

std::optional<Time> FrameDispatch::next_change(Time now) {
  if (reconsider_at_ && *reconsider_at_ <= now) reconsider_at_.reset();
  std::optional<Time> next = reconsider_at_;
  const auto at = [&](Time time) {
    if (time > now) next = std::min(next.value_or(time), time);
  };
  if (!links_.is_fleet()) return next;
  for (const QueuedFrame* frame : frames_.sent()) {
    if (frame->deliveries.size() > 1) continue;
    at(frame->ready_at);
    if (options_.hedge_after.count() > 0) at(frame->deliveries.front().sent_at + options_.hedge_after);
  }
  return next;
}

Time FrameDispatch::on_failed(ServerLink& link, QueuedFrame& frame, const absl::Status& error,
                              std::chrono::milliseconds wait, Time now) {
  if (!links_.is_fleet()) return now + wait;
  frame.failed_at.insert(link.server.id);
  if (absl::IsResourceExhausted(error)) link.rests_until = now + wait;
  const auto may_take_it = [&](const ServerLink* other) {
    return !frame.failed_at.contains(other->server.id) && !other->rests(now);
  };
  return std::ranges::any_of(links_.taking_frames(), may_take_it) ? now : now + wait;
}

void FrameDispatch::on_lost(ServerId server, bool useless, Time now) {
  constexpr std::chrono::seconds kPenalty{1};  // else it would be taken to be as fast as the fastest
  if (useless && links_.is_fleet()) record_of(server).pace.add_at_least(kPenalty, now);
}

void FrameDispatch::on_answered(ServerId server, const Delivery& delivery, Time now) {
  record_of(server).pace.add(now - delivery.sent_at, now);
}

void FrameDispatch::on_too_late(ServerId server, const Delivery& delivery, Time now) {
  record_of(server).pace.add_at_least(now - delivery.sent_at, now);
}

}  // namespace segserve::client
