// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/math/random.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

/// The color camera: soft optics, darker corners and a little noise. With noise 0 it has none of them.
struct ColorSensor {
  double noise = 1;  ///< Factor on the usual noise.

  /// Records an image whose colors (sRGB, 0 to 1) are given row by row, as 0x00RRGGBB.
  std::vector<std::uint32_t> record(std::uint32_t width, std::uint32_t height, const std::vector<Vec3>& color,
                                    Random& random) const;
};

}  // namespace segserve::synth
