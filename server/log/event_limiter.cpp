// SPDX-License-Identifier: Apache-2.0
#include "server/log/event_limiter.hpp"

namespace segserve::server {

bool EventLimiter::admit(const EventKind& kind, Time now) {
  const MutexLock lock(mutex_);
  const bool is_known = periods_.contains(kind);
  const EventKind counted = is_known || periods_.size() + 1 < most_kinds_ ? kind : EventKind{.what = "others"};
  const auto [period, is_first] = periods_.try_emplace(counted, Period{.end = now + period_});
  if (!is_first) ++period->second.more;
  return is_first;
}

std::vector<EventLimiter::Summary> EventLimiter::due(Time now) {
  std::vector<Summary> summaries;
  const MutexLock lock(mutex_);
  for (auto each = periods_.begin(); each != periods_.end();) {
    auto& [kind, period] = *each;
    if (now < period.end) {
      ++each;
    } else if (period.more == 0) {
      each = periods_.erase(each);
    } else {
      summaries.push_back({.kind = kind, .count = period.more});
      period = {.end = now + period_};
      ++each;
    }
  }
  return summaries;
}

}  // namespace segserve::server
