// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "core/tracking/rigid_motion.hpp"
#include "segserve/tracking.hpp"

namespace segserve::tracking {

inline constexpr double kLatest = 1e12;  ///< seconds, of a time

/// Whether the numbers are finite, and the rotation is one up to rounding errors.
inline bool is_rigid(const RigidTransform& transform) {
  constexpr double kTolerance = 1e-3, kFarthest = 1e9;
  const RigidMotion m = to_motion(transform);
  const auto is_one = [](double v) { return std::fabs(v - 1) <= kTolerance; };
  const auto is_none = [](double v) { return std::fabs(v) <= kTolerance; };
  const bool is_near =
      std::fabs(m.origin.x) <= kFarthest && std::fabs(m.origin.y) <= kFarthest && std::fabs(m.origin.z) <= kFarthest;
  return is_near && is_one(dot(m.x, m.x)) && is_one(dot(m.y, m.y)) && is_none(dot(m.x, m.y)) &&
         is_one(dot(cross(m.x, m.y), m.z)) && is_one(dot(m.z, m.z));
}

}  // namespace segserve::tracking
