// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace segserve::bench {

/// A rate of an open loop over some time, frames per second, that grows or falls evenly.
struct RateSegment {
  double from = 0, to = 0;  ///< at the begin and at the end; not below 0, and not both 0
  double seconds = 0;
};

/// A rate that changes with the time. At least one segment.
class RateSchedule {
 public:
  explicit RateSchedule(std::vector<RateSegment> segments) : segments_(std::move(segments)) {}

  /// The time, in seconds from the begin, at which so many frames have become due. After the last segment its last rate
  /// goes on.
  double time_of(double frames) const;

 private:
  std::vector<RateSegment> segments_;
};

/// The times at which frames shall be sent, whatever became of those before.
class Arrivals {
 public:
  /// Frame k comes when first + k frames have become due; at a constant rate at (first + k) / rate. `share` is the part
  /// of the schedule's frames that come here, above 0: clients that share a schedule evenly have 1 / clients each.
  static Arrivals constant(RateSchedule schedule, double share, double first);
  /// Frames come independently of each other, as a Poisson process whose mean is that of constant arrivals: at a
  /// constant rate the gaps between them are exponential. Equal seeds give equal times.
  static Arrivals poisson(RateSchedule schedule, double share, std::uint64_t seed);

  /// Frames come as they were recorded, over and over: frame k of each round at times[k] / speed. `times` are seconds,
  /// ascending, at least two of them. A round takes their span and a mean gap. The first frame, at time 0, is `first`.
  static Arrivals recorded(const std::vector<double>& times, double speed, std::size_t first);

  /// The time of the next frame, seconds from the beginning.
  double next();

 private:
  Arrivals(RateSchedule schedule, double share, double first, bool random, std::uint64_t seed)
      : schedule_(std::move(schedule)), share_(share), due_(first), random_(random), engine_(seed) {}

  double next_recorded();

  RateSchedule schedule_;
  double share_;
  double due_;  // frames of this client that have become due, or the place of the next one among them
  bool random_;
  std::mt19937_64 engine_;
  std::vector<double> times_ = {};  // of recorded arrivals
  double speed_ = 1;                // of recorded arrivals
  std::size_t next_ = 0;            // of recorded arrivals: frames since the beginning of the first round
  double first_ = 0;                // of recorded arrivals: the time of the first one
};

/// Seconds that a round of recorded frames takes at their own speed.
double round_seconds(const std::vector<double>& times);

}  // namespace segserve::bench
