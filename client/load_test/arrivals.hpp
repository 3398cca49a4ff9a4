// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace segserve::bench {

/// The times at which frames shall be sent, whatever became of those before.
class Arrivals {
 public:
  /// Frame k comes at (first + k) / rate. `rate` is in frames per second, above 0.
  static Arrivals constant(double rate, double first);
  /// Frames come independently of each other: the gaps between them are exponential with mean 1 / rate. Equal seeds
  /// give equal times.
  static Arrivals poisson(double rate, std::uint64_t seed);

  /// Frames come as they were recorded, over and over: frame k of each round at times[k] / speed. `times` are seconds,
  /// ascending, at least two of them. A round takes their span and a mean gap. The first frame, at time 0, is `first`.
  static Arrivals recorded(const std::vector<double>& times, double speed, std::size_t first);

  /// The time of the next frame, seconds from the beginning.
  double next();

 private:
  Arrivals(double rate, double first, bool random, std::uint64_t seed)
      : rate_(rate), first_(first), random_(random), engine_(seed) {}

  double next_recorded();

  double rate_, first_;
  double count_ = 0;  // constant arrivals so far
  double time_ = 0;   // of the last random arrival
  bool random_;
  std::mt19937_64 engine_;
  std::vector<double> times_ = {};  // of recorded arrivals
  std::size_t next_ = 0;            // of recorded arrivals: frames since the beginning of the first round
};

/// Seconds that a round of recorded frames takes at their own speed.
double round_seconds(const std::vector<double>& times);

}  // namespace segserve::bench
