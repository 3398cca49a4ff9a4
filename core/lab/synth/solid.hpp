// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/shape.hpp"
#include "core/lab/synth/texture.hpp"

namespace segserve::synth {

/// A shape in the world, whose z axis points up. Coordinates are in meters.
struct Solid {
  Shape shape;
  Pose pose;
  Texture texture;
  std::uint32_t label = 0;  ///< Ground truth: 1 to 9 for the support, 20, 30, 40 and so on for objects.
};

using World = std::vector<Solid>;

/// The box between two corners; its edges are parallel to the axes.
inline Solid box_between(const Vec3& low, const Vec3& high, const Texture& texture, std::uint32_t label = 0) {
  const Vec3 half = 0.5 * (high - low);
  return {{ShapeKind::kBox, half.x, half.y, half.z, 0}, translated(0.5 * (low + high)), texture, label};
}

}  // namespace segserve::synth
