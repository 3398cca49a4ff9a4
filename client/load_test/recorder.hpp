// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/load_test/load_report.hpp"
#include "client/load_test/run_clock.hpp"
#include "client/load_test/timeline.hpp"
#include "core/base/mutex.hpp"
#include "segserve/client/frame.hpp"

namespace segserve::bench {

/// A frame that was due.
struct SentFrame {
  std::size_t client = 0, encoding = 0, cloud = 0;
  client::Time intended = {};
  client::Time actual = {};  ///< when it was handed over, before it was encoded
  double encode_ms = 0;
};

/// Gets what became of each frame from all clients of a run, and counts it where it belongs: to the level and the
/// encoding, and to the interval of the timeline. Its memory does not grow with the frames. Thread-safe.
class Recorder {
 public:
  /// `levels`: when each level of the load ends, from the begin of the measured window, ascending. A frame belongs to
  /// the level in which it was due. `interval_s`: of the timeline.
  Recorder(const RunClock& clock, std::vector<client::Clock::duration> levels, std::size_t encodings,
           std::size_t clients, double interval_s);

  void on_offered(client::Time intended) ABSL_LOCKS_EXCLUDED(mutex_);
  void on_sent(const SentFrame& frame) ABSL_LOCKS_EXCLUDED(mutex_);
  /// The outcome has come and is decoded. Fills in the times of `record`.
  void on_outcome(const SentFrame& frame, const client::Outcome& outcome, FrameRecord record, client::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);
  /// The frame will not get any outcome, or none was waited for.
  void on_lost(const SentFrame& frame, const std::string& why, client::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  using IntervalSink = std::function<void(const TimelineEntry&, const HdrHistogram&)>;
  /// Closes the interval that is open if its time is over, or if `at_once`, with the costs of this process. Returns
  /// whether it did. `sink` gets it, and must not call the recorder.
  bool close_interval(client::Time now, double cpu_seconds, std::uint64_t rss_bytes, bool at_once,
                      const IntervalSink& sink) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Frames so far, of all levels and encodings, without their seconds.
  Report total() const ABSL_LOCKS_EXCLUDED(mutex_);
  /// The reports of one level, one for each encoding, with the seconds that the level had within the window.
  std::vector<Report> parts_of(std::size_t level) const ABSL_LOCKS_EXCLUDED(mutex_);
  Report of_level(std::size_t level) const ABSL_LOCKS_EXCLUDED(mutex_);
  std::size_t levels() const { return levels_.size(); }
  std::vector<TimelineEntry> timeline() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  double since_measured(client::Time time) const;
  /// The level of a time; none outside the window.
  std::optional<std::size_t> level_at(client::Time time) const;
  Report* report_at(client::Time time, std::size_t encoding) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  double level_seconds(std::size_t level) const;

  const RunClock& clock_;
  const std::vector<client::Clock::duration> levels_;
  const std::size_t encodings_, clients_;
  mutable Mutex mutex_;
  std::vector<Report> reports_ ABSL_GUARDED_BY(mutex_);  // by level, and then by encoding
  Timeline timeline_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::bench
