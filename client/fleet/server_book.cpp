// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/server_book.hpp"

#include <algorithm>
#include <utility>

#include "client/fleet/retry.hpp"

namespace segserve::client {

void ServerBook::set_servers(const std::vector<Server>& servers) {
  const auto known = std::exchange(entries_, {});
  for (const Server& server : servers) {
    const auto entry = known.find(server.id);
    entries_[server.id] = entry == known.end() ? Entry{} : entry->second;
  }
}

void ServerBook::failed(ServerId server, Time now, std::optional<std::chrono::milliseconds> asked_for) {
  const auto entry = entries_.find(server);
  if (entry == entries_.end()) return;  // it left the list
  ++entry->second.failures;
  entry->second.not_before = now + backoff(retry_, entry->second.failures, asked_for, random_);
}

void ServerBook::reached(ServerId server) {
  if (const auto entry = entries_.find(server); entry != entries_.end()) entry->second = {};
}

Time ServerBook::not_before(ServerId server) const {
  const auto entry = entries_.find(server);
  return entry == entries_.end() ? Time{} : entry->second.not_before;
}

bool ServerBook::is_failing(ServerId server) const {
  const auto entry = entries_.find(server);
  return entry != entries_.end() && entry->second.failures > 0;
}

bool ServerBook::nobody_in_reach() const {
  return !entries_.empty() &&
         std::ranges::all_of(entries_, [](const auto& entry) { return entry.second.failures > 0; });
}

}  // namespace segserve::client
