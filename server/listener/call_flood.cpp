// SPDX-License-Identifier: Apache-2.0
#include "server/listener/call_flood.hpp"

#include "server/scheduling/client_address.hpp"

namespace segserve::server {

bool CallFlood::on_begin(Call call, std::string_view peer, Time now) {
  const std::string name = connection_name(peer);
  const MutexLock lock(mutex_);
  --waiting_;
  const auto connection = connections_.try_emplace(name, Connection{.address = client_address(peer)}).first;
  const std::string& address = connection->second.address;
  calls_.emplace(call, connection);
  const bool is_in_excess = ++connection->second.calls > limits_.calls;
  const bool is_too_much = is_in_excess && ++excess_[address] > limits_.excess;
  const bool floods = is_too_fast(name, address, now) || is_too_much;
  if (floods) flooded_at_[address] = now;
  return floods;
}

bool CallFlood::is_too_fast(const std::string& name, const std::string& address, Time now) {
  if (now - second_began_ >= std::chrono::seconds(1)) {
    second_began_ = now;
    begun_.clear();
    std::erase_if(flooded_at_, [&](const auto& each) { return now - each.second >= limits_.probation; });
  }
  const std::int64_t of_connection = ++begun_[name], of_address = ++begun_[address];
  const bool is_need = waiting_ > limits_.waiting || flooded_at_.contains(address);
  const std::int64_t rate = is_need ? limits_.rate_in_need : limits_.rate;
  return of_address > rate && of_connection > limits_.few;
}

void CallFlood::on_end(Call call) {
  const MutexLock lock(mutex_);
  const auto found = calls_.find(call);
  if (found == calls_.end()) {
    --waiting_;
    return;
  }
  const auto connection = found->second;
  calls_.erase(found);
  if (connection->second.calls-- > limits_.calls) {
    const auto excess = excess_.find(connection->second.address);
    if (--excess->second == 0) excess_.erase(excess);
  }
  if (connection->second.calls == 0) connections_.erase(connection);
}

bool CallFlood::is_held(const std::string& address, Time now) const {
  const MutexLock lock(mutex_);
  const auto found = flooded_at_.find(address);
  return found != flooded_at_.end() && now - found->second < limits_.hold;
}

}  // namespace segserve::server
