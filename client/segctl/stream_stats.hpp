// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "client/load_test/latencies.hpp"
#include "nlohmann/json_fwd.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::segctl {

/// Statistics of a stream while it goes on: counts since its beginning, and rate and latencies of the last seconds.
/// It knows no clock. Not thread-safe.
class StreamStats {
 public:
  using Clock = std::chrono::steady_clock;
  using Time = Clock::time_point;

  /// The rate and the percentiles are those of the outcomes of this time.
  static constexpr std::chrono::seconds kWindow{10};

  explicit StreamStats(Time start) : start_(start) {}

  /// A frame that is sent later than this was not sent when its time had come.
  static constexpr std::chrono::milliseconds kPunctual{50};

  /// Counts a frame of the source, whatever becomes of it. `delay` is how much later than planned it is sent.
  void add_frame(Clock::duration delay);
  /// Counts one that could not be read or was refused.
  void add_failure() { ++failed_; }
  void add(const client::Outcome& outcome, Time now);

  std::uint64_t frames() const { return frames_; }
  std::uint64_t results() const { return results_; }
  std::uint64_t dropped() const { return dropped_; }
  std::uint64_t failed() const { return failed_; }
  /// Frames that were sent later than planned: the source, or a server that is waited for, is too slow.
  std::uint64_t late() const { return late_; }
  std::uint32_t segments() const { return segments_; }

  /// Results a second in the window.
  double rate(Time now) const;
  /// A percentile, 0 to 100, of the latencies in the window, ms; nothing without results.
  std::optional<double> latency_ms(double percent, Time now) const;

  /// A table of two lines, each shorter than so many columns: names and figures.
  std::string table(Time now, std::size_t columns) const;
  /// The figures of `table` as an object: rate and percentiles of the window.
  nlohmann::ordered_json json(Time now) const;
  /// The whole stream in a line for people, and as an object: rate and percentiles since its beginning.
  std::string summary(Time end) const;
  nlohmann::ordered_json summary_json(Time end) const;

 private:
  struct Done {
    Time at;
    double latency_ms = 0;
  };

  Time window_begin(Time now) const { return std::max(start_, now - kWindow); }

  Time start_;
  std::uint64_t frames_ = 0, results_ = 0, dropped_ = 0, failed_ = 0, late_ = 0;
  Clock::duration longest_delay_{};
  std::uint32_t segments_ = 0;  // of the last result
  std::deque<Done> done_;       // of the window
  bench::Latencies all_;        // of all results
};

}  // namespace segserve::segctl
