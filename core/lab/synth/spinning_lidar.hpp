// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// A model of a spinning LiDAR whose lasers are evenly spaced in elevation.
struct SpinningLidar {
  std::uint32_t rings = 32;      ///< 16, 32, 64 or 128; each number has the field of view of a usual sensor.
  std::uint32_t columns = 1800;  ///< Directions a turn.
  double noise = 1;              ///< Factor on the noise of ranges; 0: none, and no ray is lost.

  /// Gives the meters that a hit adds to the range that the sensor measures. It is called for each hit in order.
  using Relief = std::function<double(std::uint32_t solid, const Vec3& point, double range)>;

  /// One turn around z at `position`. Points are relative to it, without colors, one row for each ring, the uppermost
  /// first, and one column for each direction, clockwise from -x. Points without an echo are NaN.
  SyntheticScene sweep(const World& world, const Vec3& position, const Relief& relief, Random& random) const;

  /// Elevation of a ring in radians; ring 0 is the uppermost.
  double elevation(std::uint32_t ring) const;
};

}  // namespace segserve::synth
