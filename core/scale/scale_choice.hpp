// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/base/frame_context.hpp"
#include "core/base/voxel_scale.hpp"
#include "segserve/resolution.hpp"

namespace segserve {

struct ChosenScale {
  VoxelScale scale;
  ResolutionReason reason = ResolutionReason::kGiven;
  double fitting_voxel = 0;  ///< the edge that would fit, meters, if that is larger than voxels can be; else 0
};

/// Lets the cloud choose what the options of the border method leave to it: voxels are as fine as the requested scale
/// or, in a WORLD view, a hundredth of a smaller scene, but not so fine that
/// - their edge is less than 1.6 times the distance of neighboring points (CAMERA), or surfaces do not hold together
///   (WORLD, CloudSampling::connected_edge);
/// - their edge is less than 8 times the standard deviation of the noise (WORLD). The noise of a camera grows with the
///   distance; there voxels are deeper than wide from the depth at which 3 standard deviations, or 1.25 times the step
///   in depth between neighboring points of surfaces at small angles, exceed their edge; and noise counts as such in
///   the evidence from the depth at which 2 standard deviations exceed it.
/// Where cubes would have to be 10 cm or more, or the preset asks for it, a WORLD cloud that is the sweep of a LiDAR
/// (estimate_sweep_sampling) gets voxels of azimuth, elevation and range instead: 1.25 rings high, two thirds of that
/// to 1 time as wide, and at least 9 mrad. Voxels that the options fix stay so large. Seeds are 4 voxels apart unless
/// the options fix them; voxels are never larger than the distance of seeds. The paper's variants keep the requested
/// scale. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<ChosenScale> choose_scale(const FrameContext& frame);

}  // namespace segserve
