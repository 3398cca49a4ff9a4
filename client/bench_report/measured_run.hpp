// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "nlohmann/json_fwd.hpp"

namespace segserve::bench_report {

/// Frames whose latency is at most `ms`, and more than that of the bucket before.
struct Bucket {
  double ms = 0;
  double count = 0;
};

/// An entry of the timeline in the measured window.
struct Interval {
  double results = 0, failed = 0;
  std::optional<double> p50 = {}, p90 = {}, p99 = {}, max = {};  ///< ms; of all its frames
  std::optional<double> busy_cpus = {};                          ///< of the process that measured
};

/// The part of a load test that a comparison reads.
struct MeasuredRun {
  std::vector<Bucket> latency;  ///< ascending; of frames with a result
  double failed = 0;            ///< frames without one, which count as infinitely late
  std::vector<Interval> timeline;
  double step_s = 1;  ///< the length of each entry of the timeline, seconds
  double sent = 0, results = 0;
  double dropped = 0;  ///< frames that made way for newer ones, as the client was told to
  std::optional<double> frames_per_s;
  std::optional<double> client_cpu_ms, server_cpu_ms;  ///< for each frame with a result

  double frames() const;  ///< in the histogram, with the failed ones
  /// The latency in ms that the share `q` (0 to 1) of all frames do not exceed, by the nearest rank; infinity if it
  /// falls among failed frames. There must be frames.
  double quantile(double q) const;
};

/// Reads JSON that check_run accepts. Entries of the timeline that are shorter than the others are
/// left out.
MeasuredRun measured_run(const nlohmann::ordered_json& run);

}  // namespace segserve::bench_report
