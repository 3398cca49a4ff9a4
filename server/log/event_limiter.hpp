// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

/// Events that are alike. Texts may be empty.
struct EventKind {
  std::string what;  ///< e.g. "frame refused"
  std::string code = {}, reason = {}, limit = {};
  auto operator<=>(const EventKind&) const = default;
};

/// Keeps a flood of events out of the log: of each kind, the first is written at once, and those that follow within a
/// period are counted. Knows no clock. Thread-safe.
///
///     if (limiter.admit(kind, now)) write_line();
///     for (const auto& [kind, count] : limiter.due(now)) write_summary(kind, count);  // about once a second
class EventLimiter {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Events of a kind that were not written one by one.
  struct Summary {
    EventKind kind;
    std::uint64_t count = 0;
  };

  /// Beyond `most_kinds` (at least 1) at the same time, all further kinds are taken for one, "others".
  explicit EventLimiter(std::chrono::milliseconds period, std::size_t most_kinds = 64)
      : period_(period), most_kinds_(most_kinds) {}

  /// True if the event shall be written.
  bool admit(const EventKind& kind, Time now);
  /// The kinds whose period is over, if there is something to tell about them. A kind without an event in a whole
  /// period is forgotten: the next event is a first one.
  std::vector<Summary> due(Time now);
  /// All that has been counted since, whether or not the periods are over.
  std::vector<Summary> rest() { return due(Time::max() - period_); }

 private:
  struct Period {
    Time end;
    std::uint64_t more = 0;
  };

  const std::chrono::milliseconds period_;
  const std::size_t most_kinds_;
  Mutex mutex_;
  std::map<EventKind, Period> periods_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::server
