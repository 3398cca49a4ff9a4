// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/fleet.hpp"

#include <cstddef>
#include <utility>

namespace segserve::client {

Fleet::Fleet(const std::vector<std::string>& addresses, bool looks_up, const HostLookup& lookup)
    : directory_(addresses, looks_up) {
  std::vector<HostName> names;
  {
    const MutexLock lock(mutex_);
    names = directory_.names();
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    watchers_.push_back(std::make_unique<NameWatcher>(std::move(names[i]), lookup,
                                                      [this, i](const auto& answer) { return update(i, answer); }));
  }
}

ServerList Fleet::servers() {
  const MutexLock lock(mutex_);
  return directory_.list();
}

ServerList Fleet::wait_for_servers(Time until, bool patient) {
  const MutexLock lock(mutex_);
  while (directory_.list().servers.empty() && (patient || directory_.list().trouble.ok())) {
    if (!changed_.wait_until(mutex_, until)) break;
  }
  return directory_.list();
}

void Fleet::on_trouble(Time now) {
  for (const auto& watcher : watchers_) watcher->on_trouble(now);
}

std::uint64_t Fleet::subscribe(std::function<void()> changed) {
  const MutexLock lock(subscribers_mutex_);
  subscribers_[++last_subscription_] = std::move(changed);
  return last_subscription_;
}

void Fleet::unsubscribe(std::uint64_t subscription) {
  const MutexLock lock(subscribers_mutex_);
  subscribers_.erase(subscription);
}

bool Fleet::update(std::size_t name, const absl::StatusOr<std::vector<HostAddress>>& answer) {
  {
    const MutexLock lock(mutex_);
    if (!directory_.update(name, answer)) return false;
    changed_.notify_all();
  }
  const MutexLock lock(subscribers_mutex_);
  for (const auto& [subscription, changed] : subscribers_) changed();
  return true;
}

}  // namespace segserve::client
