// SPDX-License-Identifier: Apache-2.0
#include "core/scale/scale_choice.hpp"

#include <algorithm>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/scale/camera_sampling.hpp"
#include "core/scale/cloud_sampling.hpp"
#include "core/scale/sweep_sampling.hpp"

namespace segserve {
namespace {

/// The largest voxel_resolution in the table of options, meters.
constexpr double kLargestVoxel = 1;

/// Makes voxels at least so large, unless the options fix them.
void enlarge(const FrameContext& frame, double edge, ResolutionReason reason, ChosenScale& chosen) {
  if (frame.options.voxel_resolution || edge <= chosen.scale.voxel) return;
  chosen.scale.voxel = std::min(edge, kLargestVoxel);
  if (edge > kLargestVoxel) chosen.fitting_voxel = edge;
  chosen.reason = reason;
}

void choose_for_camera(const FrameContext& frame, StopCheck& check, ChosenScale& chosen) {
  constexpr double kPitches = 1.6, kGap = 3, kStep = 1.25;
  VoxelScale& scale = chosen.scale;
  CameraSampling sampling = estimate_camera_sampling(frame, scale.voxel, check);
  enlarge(frame, kPitches * sampling.pitch, ResolutionReason::kSpacing, chosen);
  // Where a column held a point at most, planes had too few of them.
  if (chosen.reason == ResolutionReason::kSpacing) sampling = estimate_camera_sampling(frame, scale.voxel, check);
  if (sampling.noise > 0) scale.noise_depth = scale.voxel / (VoxelScale::kDeviationsOfNoise * sampling.noise);
  const double step = std::max(kGap * sampling.noise, kStep * sampling.slope);
  if (step > 0) scale.elongation_depth = scale.voxel / step;
}

void choose_for_world(const FrameContext& frame, StopCheck& check, ChosenScale& chosen) {
  constexpr double kNoise = 8;
  if (frame.options.voxel_resolution) return;
  const double usual = chosen.scale.voxel;
  const CloudSampling sampling = estimate_cloud_sampling(frame, usual, check);
  if (sampling.extent > 0) chosen.scale.voxel = finest_edge(sampling.extent, usual);
  enlarge(frame, sampling.connected_edge, ResolutionReason::kSpacing, chosen);
  enlarge(frame, kNoise * sampling.noise, ResolutionReason::kNoise, chosen);
  if (chosen.scale.voxel == usual) chosen.reason = ResolutionReason::kDense;
  if (chosen.scale.voxel < usual) chosen.reason = ResolutionReason::kExtent;
}

/// Whether the points may be the sweep of a LiDAR that needs other voxels than cubes, as far as the preset and the
/// cubes tell.
bool may_need_panorama(const FrameContext& frame, const ChosenScale& cubes) {
  constexpr double kCoarse = 0.1;  // meters; finer cubes serve a room as well
  const Options& options = frame.options;
  if (options.preset != Preset::kAuto) return options.preset == Preset::kLidar;
  return cubes.reason == ResolutionReason::kSpacing && cubes.scale.voxel >= kCoarse && !options.seed_resolution;
}

/// Voxels as fine as the rays of a LiDAR's sweep, instead of cubes so large that they hold enough of its farthest
/// points.
void choose_for_sweep(const FrameContext& frame, StopCheck& check, ChosenScale& chosen) {
  constexpr double kRings = 1.25, kPitches = 1.6, kStep = 0.8;
  constexpr double kMostSlender = 1.5;  // height of a voxel over its width
  constexpr double kFinest = 0.009;     // radians; finer voxels cost time and show the relief of walls
  constexpr double kRelief = 0.15;      // meters; steps and folds of less are noise, or no border between objects
  const auto sampling = estimate_sweep_sampling(frame, check);
  if (!sampling) return;
  VoxelScale& scale = chosen.scale;
  const double height = kRings * sampling->ring;
  scale.voxel = std::max({kFinest, kPitches * sampling->azimuth, height / kMostSlender});
  scale.voxel = math::kPi / math::floor_to_int(math::kPi / scale.voxel);  // as many voxels on both sides
  const Eigen::Vector3f& sensor = *frame.view().sensor;
  scale.sweep = {sensor[0], sensor[1], sensor[2], std::max(1.0, height / scale.voxel), kRelief / scale.voxel};
  scale.elongation_depth = 1 / (kStep * sampling->slope * scale.sweep->elevation_ratio);
  scale.in_proportion = true;
  chosen.reason = ResolutionReason::kSweep;
  chosen.fitting_voxel = 0;
}

}  // namespace

absl::StatusOr<ChosenScale> choose_scale(const FrameContext& frame) {
  ChosenScale chosen{frame.scale, ResolutionReason::kGiven};
  if (frame.options.method != Method::kBorder) return chosen;
  if (!frame.options.voxel_resolution) chosen.reason = ResolutionReason::kDense;
  StopCheck check(frame.stop);
  if (frame.view().kind == ViewKind::kCamera) {
    choose_for_camera(frame, check, chosen);
  } else {
    choose_for_world(frame, check, chosen);
    if (may_need_panorama(frame, chosen)) choose_for_sweep(frame, check, chosen);
  }
  VoxelScale& scale = chosen.scale;
  if (frame.options.seed_resolution) {
    if (scale.seed < scale.voxel) chosen.reason = ResolutionReason::kGiven;
    scale.voxel = std::min(scale.voxel, scale.seed);
  } else {
    scale.seed = VoxelScale::kSeedsPerVoxel * scale.voxel;
  }
  RETURN_IF_ERROR(check.status());
  return chosen;
}

}  // namespace segserve
