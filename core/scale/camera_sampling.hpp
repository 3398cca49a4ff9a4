// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/frame_context.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {

/// How a camera sampled the scene, estimated from its points.
struct CameraSampling {
  /// The tangent of the angle between neighboring points: their distance on a surface that faces the camera at 1 m,
  /// meters. 0 if there are too few points to tell.
  double pitch = 0;
  /// The standard deviation of 1/z, 1/m, about the planes that fit the surfaces, after the mean over a voxel. A noise
  /// of so much in 1/z is one of `noise` z^2 meters in z, as stereo and structured light have it. 0 if there are too
  /// few points to tell.
  double noise = 0;
  /// The difference of 1/z, 1/m, between neighboring points of the surfaces that are seen at the smallest angles.
  double slope = 0;
};

/// Estimates the sampling of a CAMERA view from columns of points: squares of `edge` (a tangent) in (x/z, y/z). A plane
/// of the scene is a plane over these columns in 1/z, so that the residuals of planes over 5 x 5 columns tell the
/// noise. Surfaces that are not flat have larger residuals. The noise therefore is the 40th percentile, in the farther
/// half of the scene, where noise matters. Looks at a quarter of the groups of 5 x 5 columns within 64 degrees of the
/// axis. O(N). Depends neither on the order of the points nor on the CPU. Leaves off when `check` stops it.
CameraSampling estimate_camera_sampling(const FrameContext& frame, double edge, StopCheck& check);

}  // namespace segserve
