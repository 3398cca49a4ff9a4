// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "core/math/vec3.hpp"
#include "core/tracking/rigid_motion.hpp"

namespace segserve::tracking {

/// Something that stands on the support plane, in the frame of support_frame().
struct Landmark {
  Vec3 place;       ///< meters
  Vec3 color;       ///< 0..255 each
  double area = 0;  ///< square meters
};

/// The most landmarks of a frame that are compared.
inline constexpr std::size_t kMostLandmarks = 32;

/// Finds the turn about the vertical and the shift along the plane by which most landmarks of the frame before come to
/// lie on landmarks that look alike: the best of the motions that two landmarks allow, or one if it did not turn,
/// fitted to all that agree with it (least squares). `tolerance` is how far apart landmarks that agree may be, meters.
/// The identity where nothing is better. Both lists are by descending area, and at most kMostLandmarks long.
RigidMotion match_landmarks(std::span<const Landmark> before, std::span<const Landmark> now, double tolerance);

}  // namespace segserve::tracking
