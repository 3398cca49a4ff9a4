// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/call_turns.hpp"

#include <algorithm>
#include <chrono>
#include <tuple>

namespace segserve::client {

CallTurns::Use& CallTurns::use_of(ServerId server) {
  const auto [use, is_new] = uses_.try_emplace(server);
  if (is_new) use->second.turn = random_();
  return use->second;
}

CallTurns::Choice CallTurns::begin(const std::vector<Server>& servers, const ServerBook& book, Time now) {
  constexpr std::chrono::seconds kOfLate{5};
  const MutexLock lock(mutex_);
  std::erase_if(uses_, [&](const auto& use) {
    const bool is_known = std::ranges::find(servers, use.first, &Server::id) != servers.end();
    return !is_known && use.second.under_way == 0;
  });
  const auto rank = [&](const Server& server) {
    mutex_.assert_held();
    const Use& use = use_of(server.id);
    const bool failed_of_late = use.failed_at && now < *use.failed_at + kOfLate;
    return std::tuple(std::max(now, book.not_before(server.id)), failed_of_late, use.under_way, use.turn);
  };
  const Server& best = *std::ranges::min_element(servers, {}, rank);
  Use& use = use_of(best.id);
  ++use.under_way;
  use.turn = ++last_turn_;
  return {best, std::max(now, book.not_before(best.id))};
}

void CallTurns::end(ServerId server, bool reached, Time now) {
  const MutexLock lock(mutex_);
  Use& use = use_of(server);
  --use.under_way;
  use.failed_at = reached ? std::nullopt : std::optional(now);
}

}  // namespace segserve::client
