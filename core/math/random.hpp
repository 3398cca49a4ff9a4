// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve {

/// The finalizer of SplitMix64 (Steele, Lea, Flood 2014), a good 64-bit hash of its argument.
constexpr std::uint64_t mix(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15U;
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31U);
}

/// The top 53 bits as a number in [0, 1).
constexpr double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11U) * 0x1p-53; }

/// SplitMix64 with its own mappings to numbers, because those of <random> differ between libraries. Draw into named
/// variables or braces: C++ orders neither the arguments of a call nor the operands of +.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(mix(seed)) {}

  constexpr std::uint64_t bits() {
    const std::uint64_t value = mix(state_);
    state_ += 0x9E3779B97F4A7C15U;
    return value;
  }
  constexpr double uniform() { return unit_interval(bits()); }
  constexpr double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// A number in [0, count). The bias of the multiplication is below 2^-32.
  constexpr std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((bits() >> 32U) * count >> 32U);
  }
  constexpr bool chance(double probability) { return uniform() < probability; }
  /// A number with mean 0 and variance 1, from the sum of eight 16-bit uniforms (Irwin-Hall). It needs no logarithm,
  /// and has no value beyond 4.9.
  constexpr double gaussian() {
    const std::uint64_t a = bits();
    const std::uint64_t b = bits();
    std::uint64_t sum = 0;
    for (unsigned shift = 0; shift < 64; shift += 16) {
      sum += (a >> shift & 0xFFFFU) + (b >> shift & 0xFFFFU);
    }
    constexpr double kMean = 8 * 65535.0 / 2;
    constexpr double kInverseDeviation = 1.0 / 53509.96;  // sqrt(8 / 12) * 65536
    return (static_cast<double>(sum) - kMean) * kInverseDeviation;
  }

 private:
  std::uint64_t state_;
};

}  // namespace segserve
