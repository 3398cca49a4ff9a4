// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/base/frame_context.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {

/// How a spinning LiDAR sampled the scene, estimated from its points.
struct SweepSampling {
  double ring = 0;     ///< angle between neighboring rings, radians
  double azimuth = 0;  ///< angle between neighboring points of a ring, radians
  /// The difference of 1/range between neighboring rings, over their angle, 1/m, on surfaces that are seen at small
  /// angles.
  double slope = 0;
};

/// Estimates the sampling of a WORLD cloud that is one turn of a spinning LiDAR, or a sector of it, around an axis
/// along z: its rays are spread evenly, there is one surface a ray, and rings are between 0.05 and 1.5 degrees apart.
/// With the preset kLidar, rays may be spread unevenly and meet several surfaces, as those of several echoes or turns.
/// nullopt for any other cloud, also one whose view has no sensor. Coarser rings tell too little for a panorama. Looks
/// at a quarter of the directions. O(N log N). Depends neither on the order of the points nor on the CPU. Leaves off
/// when `check` stops it.
std::optional<SweepSampling> estimate_sweep_sampling(const FrameContext& frame, StopCheck& check);

}  // namespace segserve
