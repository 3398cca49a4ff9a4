#pragma once

#include <chrono>
#include <cstdint>
#include <random>

namespace segserve::bench {

/// When frames are meant to be sent, whatever became of those before: seconds from the beginning.
class Arrivals {
 public:
  /// Frame k at (first + k) / rate; `rate` per second, above 0.
  static Arrivals constant(double rate, double first);
  /// Independent of each other: gaps are exponential with mean 1 / rate. The same seed gives the same times.
  static Arrivals poisson(double rate, std::uint64_t seed);

  double next();

 private:
  Arrivals(double rate, double first, bool random, std::uint64_t seed)
      : rate_(rate), first_(first), random_(random), engine_(seed) {}

  double rate_, first_;
  double count_ = 0;  // constant: how many there were
  double time_ = 0;   // random: of the last one
  bool random_;
  std::mt19937_64 engine_;
};

}  // namespace segserve::bench
