// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/timeline.hpp"

#include <algorithm>
#include <cmath>

namespace segserve::bench {

Timeline::Timeline(double interval_s, double warm_up_s)
    : interval_(interval_s), warm_up_(warm_up_s), first_(-interval_s * std::ceil(warm_up_s / interval_s)) {}

TimelineEntry& Timeline::entry_at(double at) {
  const auto index = static_cast<std::size_t>(std::max(0.0, std::floor((at - first_) / interval_)));
  while (entries_.size() <= index) {
    const double begin = first_ + interval_ * static_cast<double>(entries_.size());
    const double t = std::max(begin, -warm_up_);
    entries_.push_back({.t = t, .seconds = begin + interval_ - t});
  }
  return entries_[index];
}

void Timeline::on_sent(double at, bool late) {
  TimelineEntry& entry = entry_at(at);
  ++entry.sent;
  if (late) ++entry.late;
}

void Timeline::on_result(double at, double latency_ms) {
  // The interval that is open may have had its time; its latencies go with its counts all the same.
  ++entry_at(std::clamp(at, first_ + interval_ * static_cast<double>(closed_), open_end() - interval_ / 1e6)).results;
  open_.add(latency_ms);
}

void Timeline::on_failed(double at) {
  ++entry_at(std::clamp(at, first_ + interval_ * static_cast<double>(closed_), open_end() - interval_ / 1e6)).failed;
  open_.add_failure();
}

const TimelineEntry& Timeline::close(double at, double cpu_seconds, std::uint64_t rss_bytes) {
  TimelineEntry& entry = entry_at(open_end() - interval_ / 2);
  entry.seconds = std::min(entry.seconds, std::max(at - entry.t, 1e-3));
  if (open_.results() > 0) {
    entry.p50_ms = open_.percentile(50);
    entry.p90_ms = open_.percentile(90);
    entry.p99_ms = open_.percentile(99);
    entry.max_ms = open_.max();
  }
  entry.client_busy_cpus = cpu_seconds / entry.seconds;
  entry.client_rss_bytes = rss_bytes;
  open_ = {};
  ++closed_;
  return entry;
}

std::vector<TimelineEntry> Timeline::entries() const {
  return {entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(std::min(closed_, entries_.size()))};
}

}  // namespace segserve::bench
