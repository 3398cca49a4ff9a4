// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/depth_raster.hpp"
#include "core/math/random.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

/// A model of a pair of cameras whose images are compared in windows of a few pixels.
struct StereoSensor {
  double focal = 525;       ///< Pixels.
  double baseline = 0.055;  ///< From the left camera, whose image it is, to the right one, in meters.
  double noise = 1;         ///< Factor on the usual noise; 0: neither noise nor disparity steps, and sharp edges.
  bool holes = true;        ///< What one camera sees alone, grazing angles, and surfaces without texture.
  bool projector = true;    ///< A projector adds texture, less of it the farther the surface is.

  /// Turns a perfect image into a measured one, in place. `color` has the picture of the left camera (sRGB, 0 to 1).
  /// Noise grows with the square of the depth and with the lack of texture, and its waves are some pixels long. Objects
  /// grow by about the half of a window, and labels go with the depths; points between two surfaces get label 0.
  /// Pixels that cannot be measured get depth 0.
  void measure(const std::vector<Vec3>& color, DepthImage& image, Random& random) const;
};

}  // namespace segserve::synth
