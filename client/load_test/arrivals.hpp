// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <random>

namespace segserve::bench {

/// The times at which frames shall be sent, whatever became of those before.
class Arrivals {
 public:
  /// Frame k comes at (first + k) / rate. `rate` is in frames per second, above 0.
  static Arrivals constant(double rate, double first);
  /// Frames come independently of each other: the gaps between them are exponential with mean 1 / rate. Equal seeds
  /// give equal times.
  static Arrivals poisson(double rate, std::uint64_t seed);

  /// The time of the next frame, seconds from the beginning.
  double next();

 private:
  Arrivals(double rate, double first, bool random, std::uint64_t seed)
      : rate_(rate), first_(first), random_(random), engine_(seed) {}

  double rate_, first_;
  double count_ = 0;  // constant arrivals so far
  double time_ = 0;   // of the last random arrival
  bool random_;
  std::mt19937_64 engine_;
};

}  // namespace segserve::bench
