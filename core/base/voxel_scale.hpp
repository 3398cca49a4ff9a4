// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve {

/// The panorama of a spinning LiDAR around the z axis. Its voxels are cells of azimuth, elevation and range, whose size
/// in meters is in proportion to the range, as the distance between neighboring points is.
struct SweepProjection {
  /// Points nearer to the sensor, meters, are no measurement: rays without an echo, or the housing.
  static constexpr double kNearest = 0.1;

  double x = 0, y = 0, z = 0;  ///< position of the sensor, meters
  double elevation_ratio = 1;  ///< height of a voxel over its width: rings are farther apart than points of a ring
  double noise_range = 0;      ///< meters, below which noise, and relief that is no border, exceed a voxel
};

/// How large the voxels and supervoxels of a frame are, everywhere in the scene.
struct VoxelScale {
  static constexpr double kSeedsPerVoxel = 4;  ///< of a seed resolution that follows the voxels

  double voxel = 0;  ///< edge of a voxel, meters; in a CAMERA view and in a sweep at 1 m distance
  double seed = 0;   ///< distance between the seeds of supervoxels, meters
  /// Whether all lengths, not only the edge of a voxel, are in proportion to the depth, so that a scene and its copy at
  /// twice the distance are segmented alike. `seed` is then the distance at 1 m. Only the border method in a CAMERA
  /// view or a sweep does so: the paper's variants have seeds at fixed distances, as PCL.
  bool in_proportion = false;
  std::optional<SweepProjection> sweep;  ///< set for a LiDAR's sweep in a WORLD view; its depth is the range
  /// CAMERA view or sweep: the depth, meters, from which voxels are deeper than wide, because neighboring points of a
  /// surface lie farther apart in depth than the edge of a voxel, by noise or because the surface is seen at a grazing
  /// angle. The depth of voxels then grows with the square of z, as both of these do.
  double elongation_depth = std::numeric_limits<double>::infinity();
  /// CAMERA view: the depth, meters, from which the noise of the sensor, as 2 standard deviations, exceeds the edge of
  /// a voxel.
  double noise_depth = std::numeric_limits<double>::infinity();
  static constexpr double kDeviationsOfNoise = 2;

  /// CAMERA view: the standard deviation of 1/z by the noise, 1/m, as mean over the points of a voxel.
  double noise() const { return voxel / (kDeviationsOfNoise * noise_depth); }

  /// The ratio of the depth of a voxel at depth z to its width.
  double elongation(double z) const { return z > elongation_depth ? z / elongation_depth : 1; }

  /// The number of edges of a voxel by which the noise at depth z exceeds one edge, in [0, 1]. It ends at 1, because
  /// corners of a right angle stay visible in any noise. The noise of a camera grows with the depth faster than voxels
  /// do; that of a LiDAR is the same at any range.
  double excess_noise(double z) const {
    if (sweep) return z < sweep->noise_range ? std::min(1.0, sweep->noise_range / z - 1) : 0;
    return z > noise_depth ? std::min(1.0, z / noise_depth - 1) : 0;
  }
};

/// The scale for which the options ask. Where they leave it to the cloud, it is the finest that choose_scale takes for
/// scenes of the usual size: 7 mm at 1 m in a CAMERA view and 7.5 mm in a WORLD view.
inline VoxelScale requested_scale(const Options& options, const View& view) {
  constexpr double kCameraVoxel = 0.007, kWorldVoxel = 0.0075;
  const bool camera = view.kind == ViewKind::kCamera;
  VoxelScale scale;
  scale.voxel = options.voxel_resolution.value_or(camera ? kCameraVoxel : kWorldVoxel);
  scale.seed = options.seed_resolution.value_or(VoxelScale::kSeedsPerVoxel * scale.voxel);
  scale.in_proportion = camera && options.method == Method::kBorder;
  return scale;
}

}  // namespace segserve
