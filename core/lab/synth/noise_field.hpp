// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/math/random.hpp"

namespace segserve::synth {

/// Noise with mean 0 and variance 1 at every pixel of an image, which is correlated over cells of some pixels.
class NoiseField {
 public:
  NoiseField(std::uint32_t width, std::uint32_t height, double cell, Random& random)
      : inverse_cell_(1 / cell),
        across_(static_cast<std::size_t>(width / cell) + 2),
        value_(across_ * (static_cast<std::size_t>(height / cell) + 2)) {
    for (double& value : value_) value = random.gaussian();
  }

  double at(std::uint32_t u, std::uint32_t v) const {
    const Blend across = blend(u * inverse_cell_), down = blend(v * inverse_cell_);
    const double* cell = value_.data() + down.cell * across_ + across.cell;
    const double top = across.low * cell[0] + across.high * cell[1];
    const double bottom = across.low * cell[across_] + across.high * cell[across_ + 1];
    return down.low * top + down.high * bottom;
  }

 private:
  /// The weights of two neighboring values; the sum of their squares is 1.
  struct Blend {
    std::size_t cell;
    double low, high;
  };
  static Blend blend(double position) {
    const double cell = std::floor(position);
    const double t = position - cell, high = t * t * (3 - 2 * t), low = 1 - high;
    const double length = std::sqrt(low * low + high * high);
    return {static_cast<std::size_t>(cell), low / length, high / length};
  }

  double inverse_cell_;
  std::size_t across_;
  std::vector<double> value_;
};

}  // namespace segserve::synth
