// SPDX-License-Identifier: Apache-2.0
#include "client/stream/server_links.hpp"

#include <algorithm>
#include <utility>

#include "client/fleet/retry.hpp"
#include "client/stream/stream_message.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::client {

ServerLinks::ServerLinks(const StreamOptions& options, std::uint32_t seed)
    : options_(options), random_(seed), book_(options_.retry, seed) {}

void ServerLinks::set_servers(const ServerList& list) {
  servers_ = list.servers;
  book_.set_servers(servers_);
  for (const Server& server : servers_) {
    if (!preference_.contains(server.id)) preference_[server.id] = random_();
  }
  const auto is_listed = [&](ServerId id) { return std::ranges::find(servers_, id, &Server::id) != servers_.end(); };
  std::erase_if(preference_, [&](const auto& entry) { return !is_listed(entry.first); });
  if (servers_.size() > options_.max_servers) {
    std::ranges::sort(servers_, {}, [&](const Server& server) { return preference_.at(server.id); });
  }
  for (auto& [id, link] : links_) {
    if (!is_listed(link.server.id)) link.protocol.end();
  }
  if (servers_.empty()) last_error_ = list.trouble;
}

ServerLink* ServerLinks::find(ConnectionId id) {
  const auto found = links_.find(id);
  return found == links_.end() || !found->second.broken.ok() ? nullptr : &found->second;
}

std::vector<ServerLink*> ServerLinks::taking_frames() {
  std::vector<ServerLink*> links;
  for (auto& [id, link] : links_) {
    if (link.takes_frames()) links.push_back(&link);
  }
  return links;
}

bool ServerLinks::out_of_reach() const {
  const bool one_takes_frames =
      std::ranges::any_of(links_, [](const auto& entry) { return entry.second.takes_frames(); });
  if (one_takes_frames) return false;
  return servers_.empty() ? !last_error_.ok() : book_.nobody_in_reach();
}

void ServerLinks::on_opened(const ServerLink& link) {
  book_.reached(link.server.id);
  for (auto& [id, other] : links_) {
    if (other.is_old && other.server.id == link.server.id) other.protocol.end();
  }
}

void ServerLinks::on_old(ServerLink& link) {
  if (!std::exchange(link.is_old, true)) request(LinkAction::kRenew, link);
}

bool ServerLinks::has_link(ServerId server) const {
  return std::ranges::any_of(links_, [server](const auto& entry) {
    const ServerLink& link = entry.second;
    return link.server.id == server && link.broken.ok() && !link.protocol.ending() && !link.is_old;
  });
}

std::vector<Server> ServerLinks::wanted() const {
  std::vector<Server> wanted;
  std::size_t in_reach = 0;
  for (const Server& server : servers_) {
    if (in_reach >= options_.max_servers) break;
    wanted.push_back(server);
    if (!book_.is_failing(server.id)) ++in_reach;
  }
  return wanted;
}

void ServerLinks::open(const Server& server, Time now) {
  const ConnectionId id = ++last_id_;
  StreamProtocol protocol(open_message(options_));
  ServerLink link{.id = id, .server = server, .protocol = std::move(protocol), .silence = Silence(now)};
  request(LinkAction::kOpen, link);
  links_.emplace(id, std::move(link));
}

std::optional<Time> ServerLinks::open_missing(Time now) {
  const std::vector<Server> servers = wanted();
  for (auto& [id, link] : links_) {
    const bool is_wanted = std::ranges::find(servers, link.server.id, &Server::id) != servers.end();
    if (!is_wanted) link.protocol.end();
  }
  std::optional<Time> next;
  const auto call_again = [&next](Time time) { next = std::min(next.value_or(time), time); };
  for (const Server& server : servers) {
    if (has_link(server.id)) continue;
    const Time not_before = book_.not_before(server.id);
    if (not_before > now) {
      call_again(not_before);
      continue;
    }
    open(server, now);
    call_again(now);  // to watch its silence
  }
  return next;
}

std::optional<Time> ServerLinks::check_silence(UsualTime usual_time, Time now) {
  const Clock::duration stood_still = silence_clock_.check(now);
  std::optional<Time> next;
  for (auto& [id, link] : links_) {
    link.silence.forgive(stood_still, now);
    const StreamProtocol& protocol = link.protocol;
    const bool owes_us = !protocol.opened() || protocol.in_flight() > 0 || protocol.ending();
    if (!link.broken.ok() || !owes_us) continue;
    // A server opens a stream at once, be it the only one.
    const SilenceLimits limits = is_fleet() || !protocol.opened()
                                     ? hasty_silence_limits(options_.progress_timeout, usual_time(link.server.id))
                                     : silence_limits(options_.progress_timeout);
    const Silence::Verdict verdict = link.silence.check(limits, now);
    if (verdict == Silence::Verdict::kDead && link.silence.is_answered_by_another()) {
      const std::string message = fmt::format("{} answers calls, but opens no stream", link.server.address);
      break_link(link, LinkAction::kBreak, absl::UnavailableError(message), now);
      continue;
    }
    if (verdict == Silence::Verdict::kDead) {
      const auto silence = options_.progress_timeout.count();
      const std::string message = fmt::format("{} showed no sign of life for {} ms", link.server.address, silence);
      break_link(link, LinkAction::kBreakSilent, absl::UnavailableError(message), now);
      continue;
    }
    if (verdict == Silence::Verdict::kProbe) request(LinkAction::kProbe, link);
    const Time due = link.silence.due(limits);
    next = std::min(next.value_or(due), due);
  }
  silence_clock_.set_due(next);
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

void ServerLinks::on_failed(ServerId server, Time now, std::optional<std::chrono::milliseconds> asked_for) {
  book_.failed(server, now, asked_for);
  trouble_ = true;
}

void ServerLinks::break_link(ServerLink& link, LinkAction::Kind kind, absl::Status why, Time now) {
  link.broken = std::move(why);
  request(kind, link);
  last_error_ = link.broken;
  on_failed(link.server.id, now, std::nullopt);
}

void ServerLinks::on_sign_of_life(ConnectionId id, Time now) {
  const auto link = links_.find(id);
  if (link != links_.end()) link->second.silence.on_sign_of_life(now);
}

void ServerLinks::on_probe_answered(ConnectionId id, Time now) {
  ServerLink* link = find(id);
  if (link == nullptr) return;
  if (link->protocol.opened()) return link->silence.on_sign_of_life(now);
  link->silence.on_answered_by_another(now);
}

void ServerLinks::on_draining(const ServerLink& link, Time now) {
  on_failed(link.server.id, now, std::nullopt);
  last_error_ = absl::UnavailableError(fmt::format("{} is about to stop", link.server.address));
}

std::optional<ServerLinks::End> ServerLinks::on_closed(ConnectionId id, const absl::Status& status, Time now) {
  const auto found = links_.find(id);
  if (found == links_.end()) return std::nullopt;
  const ServerLink link = std::move(found->second);
  links_.erase(found);
  End end{.why = link.broken, .fatal = false, .server = link.server.id};
  end.useless = link.protocol.in_flight() > 0 && !link.has_answered;
  if (!link.broken.ok()) return end;
  end.why = unavailable_if_cancelled(status);
  if (end.why.ok()) end.why = absl::UnavailableError(fmt::format("{} closed the stream", link.server.address));
  const bool expected = link.protocol.ending() && link.protocol.in_flight() == 0;
  if (expected) return end;
  last_error_ = end.why;
  if (!link.protocol.ending()) on_failed(link.server.id, now, wire::details_of(end.why).retry_delay);
  end.fatal = !is_worth_reconnecting(end.why) && out_of_reach();
  return end;
}

}  // namespace segserve::client
