// SPDX-License-Identifier: Apache-2.0
#include "client/stream/server_links.hpp"

#include <algorithm>
#include <utility>

#include "client/calls/retry.hpp"
#include "client/stream/stream_message.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::client {

ServerLinks::ServerLinks(const StreamOptions& options, std::vector<std::string> addresses, std::size_t first_address,
                         std::uint32_t seed)
    : options_(options),
      addresses_(std::move(addresses)),
      book_(addresses_.size(), first_address, options_.retry, seed) {}

ServerLink* ServerLinks::find(ConnectionId id) {
  const auto found = links_.find(id);
  return found == links_.end() || !found->second.broken.ok() ? nullptr : &found->second;
}

std::optional<Time> ServerLinks::open_if_needed(Time now) {
  const bool there_is_one = std::ranges::any_of(
      links_, [](const auto& entry) { return entry.second.broken.ok() && !entry.second.protocol.ending(); });
  if (there_is_one) return std::nullopt;
  const AddressBook::Choice choice = book_.choose(now);
  if (choice.not_before > now) return choice.not_before;
  const ConnectionId id = ++last_id_;
  const auto [link, inserted] = links_.emplace(id, ServerLink{.id = id,
                                                              .address = choice.address,
                                                              .protocol = StreamProtocol(open_message(options_)),
                                                              .last_sign_of_life = now});
  request(LinkAction::kOpen, link->second);
  return now + options_.progress_timeout / 2;
}

std::optional<Time> ServerLinks::check_silence(Time now) {
  const auto patience = options_.progress_timeout / 2;  // for a sign of life, and then for the answer to a probe
  std::optional<Time> next;
  for (auto& [id, link] : links_) {
    const StreamProtocol& protocol = link.protocol;
    const bool owes_us = !protocol.opened() || protocol.in_flight() > 0 || protocol.ending();
    if (!link.broken.ok() || !owes_us) continue;
    if (link.probed_at && now >= *link.probed_at + patience) {
      const auto silence = options_.progress_timeout.count();
      const std::string message = fmt::format("{} showed no sign of life for {} ms", address_of(link), silence);
      break_link(link, LinkAction::kBreakSilent, absl::UnavailableError(message), now);
      continue;
    }
    if (!link.probed_at && now >= link.last_sign_of_life + patience) {
      link.probed_at = now;
      request(LinkAction::kProbe, link);
    }
    const Time due = link.probed_at.value_or(link.last_sign_of_life) + patience;
    next = std::min(next.value_or(due), due);
  }
  return next;
}

void ServerLinks::end_all() {
  for (auto& [id, link] : links_) link.protocol.end();
}

void ServerLinks::break_all() {
  for (auto& [id, link] : links_) {
    if (!link.broken.ok()) continue;
    link.broken = absl::CancelledError("the stream was closed");
    request(LinkAction::kBreak, link);
  }
}

void ServerLinks::break_link(ServerLink& link, LinkAction::Kind kind, absl::Status why, Time now) {
  link.broken = std::move(why);
  request(kind, link);
  last_error_ = link.broken;
  book_.failed(link.address, now, std::nullopt);
}

void ServerLinks::on_sign_of_life(ConnectionId id, Time now) {
  const auto link = links_.find(id);
  if (link == links_.end()) return;
  link->second.last_sign_of_life = now;
  link->second.probed_at.reset();
}

void ServerLinks::on_draining(const ServerLink& link, Time now) {
  book_.failed(link.address, now, std::nullopt);
  last_error_ = absl::UnavailableError(fmt::format("{} is about to stop", address_of(link)));
}

std::optional<ServerLinks::End> ServerLinks::on_closed(ConnectionId id, const absl::Status& status, Time now) {
  const auto found = links_.find(id);
  if (found == links_.end()) return std::nullopt;
  const ServerLink link = std::move(found->second);
  links_.erase(found);
  if (!link.broken.ok()) return End{link.broken};
  absl::Status why = unavailable_if_cancelled(status);
  if (why.ok()) why = absl::UnavailableError(fmt::format("{} closed the stream", address_of(link)));
  const bool expected = link.protocol.ending() && link.protocol.in_flight() == 0;
  if (expected) return End{why};
  if (!is_worth_reconnecting(why)) return End{why, true};
  last_error_ = why;
  if (!link.protocol.ending()) book_.failed(link.address, now, wire::details_of(why).retry_delay);
  return End{why};
}

}  // namespace segserve::client
