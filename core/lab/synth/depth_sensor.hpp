#pragma once

#include <cstdint>
#include <vector>

#include "core/math/random.hpp"

namespace segserve::synth {

/// A perfect picture of depth, row by row.
struct DepthImage {
  std::uint32_t width = 0, height = 0;
  std::vector<double> depth;         ///< metres along the optical axis; 0: nothing
  std::vector<float> incidence;      ///< cosine between the ray and the surface's normal, [0, 1]
  std::vector<std::uint32_t> label;  ///< ground truth
};

/// What a structured-light sensor (Kinect v1) makes of it.
struct DepthSensor {
  double focal = 525;       ///< pixels
  double baseline = 0.075;  ///< metres from camera to projector, which is on the right
  double noise = 1;         ///< times the usual noise; 0: none, nor disparity steps
  bool holes = true;        ///< shadow of the projector, grazing angles, spots without depth

  /// Measures in place: depths get noise and steps, borders fray (their labels move along with
  /// their depths), pixels that cannot be measured get depth 0.
  void measure(DepthImage& image, Random& random) const;
};

/// Axial noise of the Kinect v1 at a depth, standard deviation in metres (Nguyen, Izadi, Lovell 2012).
constexpr double axial_noise(double depth) { return 0.0012 + 0.0019 * (depth - 0.4) * (depth - 0.4); }

}  // namespace segserve::synth
