// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

namespace segserve::bench_report {

/// The figures that a load test has at the end of an interval, mostly a second.
struct LiveSnapshot {
  double t = 0;                                   ///< seconds since the measured window began; negative in the warm-up
  double seconds = 1;                             ///< how long the interval is
  double offered = 0;                             ///< frames that were due in it; 0 in a closed loop
  double results = 0;                             ///< that came in it
  double failed = 0;                              ///< frames that ended in it without a result
  std::optional<double> p50_ms, p99_ms;           ///< of this interval; infinite among failed frames
  std::uint64_t all_results = 0, all_failed = 0;  ///< since the measured window began
  std::optional<double> all_p50_ms, all_p99_ms;   ///< of these
};

/// How a terminal shows texts.
struct LiveStyle {
  std::size_t columns = 80;
  bool has_color = true;
  bool has_unicode = true;  ///< bars of eight heights; otherwise letters of ASCII
};

/// A few lines about a load test that goes on: rate, percentiles and failures of the last interval and so far, and the
/// p99 of the last intervals as a sparkline. It redraws them in place. It only makes texts: somebody else writes them.
class LiveView {
 public:
  /// `title` tells the load, e.g. "4 clients, planar".
  explicit LiveView(std::string title) : title_(std::move(title)) {}

  void set_progress(double share) { share_ = share; }
  void add(const LiveSnapshot& snapshot);

  /// The lines, each of fewer than `style.columns` characters, with a line feed behind each.
  std::string lines(const LiveStyle& style) const;
  /// Returns the same lines, with the control sequences that draw them over those of the call before.
  std::string redraw(const LiveStyle& style);
  /// Returns the control sequences that remove the lines from the screen; empty if there are none.
  std::string wipe();

 private:
  std::string title_;
  double share_ = 0;
  std::optional<LiveSnapshot> last_;
  std::deque<std::optional<double>> p99_;  // ms, of the last intervals
  std::size_t drawn_lines_ = 0;
};

}  // namespace segserve::bench_report
