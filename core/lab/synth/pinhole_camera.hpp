// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/lab/synth/geometry.hpp"

namespace segserve::synth {

/// A pinhole camera: x to the right, y down, z forward; pixel (u, v) looks along
/// ((u - center_u) / focal, (v - center_v) / focal, 1).
struct Camera {
  Pose pose;
  double focal = 0;  ///< pixels
  double center_u = 0, center_v = 0;
  std::uint32_t width = 0, height = 0;

  Vec3 ray(double u, double v) const { return {(u - center_u) / focal, (v - center_v) / focal, 1}; }
};

/// A camera at `from` that looks at `to` with a level horizon. It must not look straight up or down.
inline Camera look_at(const Vec3& from, const Vec3& to, double focal, std::uint32_t width, std::uint32_t height) {
  const Vec3 forward = unit(to - from);
  const Vec3 right = unit(cross(forward, {0, 0, 1}));
  return {{right, cross(forward, right), forward, from}, focal, (width - 1) / 2.0, (height - 1) / 2.0, width, height};
}

}  // namespace segserve::synth
