// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace segserve::synth {

/// A perfect depth image, row by row.
struct DepthImage {
  std::uint32_t width = 0, height = 0;
  std::vector<double> depth;         ///< Along the optical axis, in meters; 0 for no surface.
  std::vector<float> incidence;      ///< Cosine of the angle between the ray and the normal, [0, 1].
  std::vector<std::uint32_t> label;  ///< Ground truth.
};

}  // namespace segserve::synth
