// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "client/load_test/latencies.hpp"

namespace segserve::bench {

/// The events of one interval of a run, mostly a second.
struct TimelineEntry {
  double t = 0;               ///< its begin, seconds since the measured window began; negative in the warm-up
  double seconds = 0;         ///< how long it is
  std::uint64_t offered = 0;  ///< frames that were due
  std::uint64_t sent = 0;     ///< frames that were handed over
  std::uint64_t results = 0;  ///< that came
  std::uint64_t failed = 0;   ///< frames that ended without a result
  std::uint64_t late = 0;     ///< frames that were handed over more than 1 ms late
  /// Latencies from the intended time of sending, of the frames that ended in this interval; infinity among failed
  /// frames; unset without results.
  std::optional<double> p50_ms = {}, p90_ms = {}, p99_ms = {}, max_ms = {};
  double client_busy_cpus = 0;         ///< that this process kept busy on the average
  std::uint64_t client_rss_bytes = 0;  ///< of this process, at the end of the interval
};

/// A run in intervals of equal length. Memory grows with their number only. Not thread-safe.
class Timeline {
 public:
  /// Interval 0 begins with the measured window; those before it are of the warm-up, whose first may be cut short.
  Timeline(double interval_s, double warm_up_s);

  // Times are seconds since the measured window began.
  void on_offered(double at) { ++entry_at(at).offered; }
  void on_sent(double at, bool late);
  void on_result(double at, double latency_ms);
  void on_failed(double at);

  /// Ends the interval that is open, at its planned end or earlier, with the costs of this process in it. Returns it.
  const TimelineEntry& close(double at, double cpu_seconds, std::uint64_t rss_bytes);
  /// The latencies of the interval that is open.
  const HdrHistogram& open_latencies() const { return open_.histogram(); }
  double open_end() const { return first_ + interval_ * static_cast<double>(closed_ + 1); }

  /// All intervals that were closed.
  std::vector<TimelineEntry> entries() const;

 private:
  TimelineEntry& entry_at(double at);

  const double interval_, warm_up_;
  const double first_;  // the begin of the first interval, a multiple of their length
  std::vector<TimelineEntry> entries_;
  std::size_t closed_ = 0;
  Latencies open_;
};

}  // namespace segserve::bench
