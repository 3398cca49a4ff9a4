// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/lab/synth/depth_raster.hpp"
#include "core/math/random.hpp"

namespace segserve::synth {

/// A model of a structured-light sensor (Kinect v1).
struct DepthSensor {
  double focal = 525;       ///< Pixels.
  double baseline = 0.075;  ///< From the camera to the projector on its right, in meters.
  double noise = 1;         ///< Factor on the usual noise; 0: neither noise nor disparity steps.
  bool holes = true;        ///< Shadow of the projector, grazing angles, spots without depth.

  /// Turns a perfect image into a measured one, in place: depths get noise and steps, borders fray (labels move with
  /// the depths), and pixels that cannot be measured get depth 0.
  void measure(DepthImage& image, Random& random) const;
};

/// Standard deviation, in meters, of the axial noise of the Kinect v1 at a depth in meters (Nguyen, Izadi, Lovell
/// 2012).
constexpr double axial_noise(double depth) { return 0.0012 + 0.0019 * (depth - 0.4) * (depth - 0.4); }

}  // namespace segserve::synth
