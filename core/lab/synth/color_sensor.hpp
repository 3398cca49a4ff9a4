#pragma once

#include <cstdint>
#include <vector>

#include "core/math/random.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

/// The colour camera: soft optics, darker corners, a little noise; none of them with noise 0.
struct ColorSensor {
  double noise = 1;  ///< times the usual noise

  /// Colours (sRGB, 0 to 1, row by row) as 0x00RRGGBB.
  std::vector<std::uint32_t> record(std::uint32_t width, std::uint32_t height, const std::vector<Vec3>& color,
                                    Random& random) const;
};

}  // namespace segserve::synth
