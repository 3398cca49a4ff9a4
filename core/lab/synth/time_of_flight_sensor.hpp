// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/depth_raster.hpp"
#include "core/math/random.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

/// A model of a camera that lights the scene and measures the time until the light comes back (Kinect v2).
struct TimeOfFlightSensor {
  double focal = 525;  ///< Pixels.
  double noise = 1;    ///< Factor on the usual noise; 0: no noise, sharp edges and corners.
  bool holes = true;   ///< Surfaces that send too little light back.

  /// Turns a perfect image into a measured one, in place. `color` is a picture of the scene (sRGB, 0 to 1), which tells
  /// how much light surfaces reflect. Noise grows as the light that comes back fades. Pixels at silhouettes see two
  /// surfaces; they fly between them and get label 0. Light that goes from one wall of a concave corner to the other
  /// rounds the corner. Pixels that cannot be measured get depth 0.
  void measure(const std::vector<Vec3>& color, DepthImage& image, Random& random) const;
};

/// Standard deviation, in meters, of the depth at a depth in meters. `reflected` is the share of the light that a
/// surface sends back, as it is turned, (0, 1].
constexpr double time_of_flight_noise(double depth, double reflected) {
  return 0.0012 + 0.00025 * depth * depth / reflected;
}

}  // namespace segserve::synth
