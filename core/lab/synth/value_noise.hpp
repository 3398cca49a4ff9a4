// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "core/math/random.hpp"

namespace segserve::synth {

/// The hash of a lattice point.
constexpr std::uint64_t lattice_hash(std::int64_t i, std::int64_t j, std::uint64_t seed) {
  return mix(seed ^ mix(static_cast<std::uint64_t>(i) * 0x8CB92BA72F3D8DD7U + static_cast<std::uint64_t>(j)));
}

/// Continuous value noise in [0, 1) with one lattice value per unit.
inline double value_noise(double u, double v, std::uint64_t seed) {
  const double fu = std::floor(u);
  const double fv = std::floor(v);
  const auto i = static_cast<std::int64_t>(fu);
  const auto j = static_cast<std::int64_t>(fv);
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const double su = smooth(u - fu);
  const double sv = smooth(v - fv);
  const double n00 = unit_interval(lattice_hash(i, j, seed));
  const double n10 = unit_interval(lattice_hash(i + 1, j, seed));
  const double n01 = unit_interval(lattice_hash(i, j + 1, seed));
  const double n11 = unit_interval(lattice_hash(i + 1, j + 1, seed));
  const double low = n00 + (n10 - n00) * su;
  return low + (n01 + (n11 - n01) * su - low) * sv;
}

/// Three octaves of value noise, in [0, 1).
inline double fractal_noise(double u, double v, std::uint64_t seed) {
  return (4 * value_noise(u, v, seed) + 2 * value_noise(2 * u, 2 * v, seed + 1) + value_noise(4 * u, 4 * v, seed + 2)) /
         7;
}

}  // namespace segserve::synth
