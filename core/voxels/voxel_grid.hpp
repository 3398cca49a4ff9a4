// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/elementary.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_key.hpp"
#include "segserve/cloud.hpp"

namespace segserve {

/// The occupied voxels of a cloud, in ascending order of their keys. The grid's origin is fixed, and sums are taken in
/// integers, so the voxels depend neither on the order of the points nor on the number of threads.
struct VoxelGrid {
  std::vector<VoxelKey> key;          ///< V
  std::vector<Vec3> centroid;         ///< V: mean of the voxel's points, meters, the cloud's frame
  std::vector<Vec3> color_sum;        ///< V: sum of (R, G, B), 0..255 each, over its points; whole numbers
  std::vector<std::uint32_t> points;  ///< V: number of its points
  std::vector<std::uint8_t> camera;   ///< V: the camera that saw it (find_seeing_cameras); empty without cameras

  // Each voxel has a slot, from 1 on in the order in which its first point appears. Points refer to slots, so that a
  // value for each voxel becomes one for each point by a single gather.

  /// N: the slot of every point; 0 for a point that is not finite, or not selected.
  std::vector<std::uint32_t> slot_of_point;
  /// V + 1: the voxel of every slot; kNoVoxel for voxels that were removed. Entry 0 is not used.
  std::vector<std::uint32_t> voxel_of_slot;
  std::size_t finite_points = 0;       ///< of the cloud, selected or not; zeros in a CAMERA view do not count
  std::size_t zero_points = 0;         ///< selected points at (0, 0, 0) in a CAMERA view, or at the sensor of a sweep
  std::size_t points_beyond_grid = 0;  ///< selected finite points that are too far away to have a voxel

  std::size_t size() const { return key.size(); }
};

inline constexpr std::uint32_t kNoVoxel = ~std::uint32_t{0};

/// From the sensor of a sweep to a point, meters.
inline Vec3 ray_to(const SweepProjection& sweep, const Vec3& p) {
  return {p.x - sweep.x, p.y - sweep.y, p.z - sweep.z};
}

/// The depth of a point, meters: its range in a sweep, z in a CAMERA view.
inline double depth_of(const VoxelScale& scale, const Vec3& p) {
  return scale.sweep ? norm(ray_to(*scale.sweep, p)) : p.z;
}

/// Edge of a voxel at `position`, meters. In a CAMERA view and in a sweep it grows with the distance.
inline double voxel_edge(const VoxelScale& scale, const View& view, const Vec3& position) {
  return scale.sweep || view.kind == ViewKind::kCamera ? scale.voxel * depth_of(scale, position) : scale.voxel;
}

/// A point of a CAMERA view or a sweep in the space in which all voxels are cubes of the same size: (x/z, y/z, g(z)),
/// or (azimuth, elevation over the ratio of a voxel's height to its width, g(range)), in radians. Here g is the
/// logarithm up to the depth from which voxels are deeper than wide, and goes on with the inverse of the depth.
inline Vec3 to_voxel_space(const VoxelScale& scale, const Vec3& p) {
  const double far = scale.elongation_depth, depth = depth_of(scale, p);
  const double g = depth > far ? math::ln(far) + (1 - far / depth) : math::ln(depth);
  if (!scale.sweep) return {p.x / p.z, p.y / p.z, g};
  const Vec3 ray = ray_to(*scale.sweep, p);
  const double elevation = math::atan2(ray.z, std::sqrt(ray.x * ray.x + ray.y * ray.y));
  return {math::atan2(ray.y, ray.x), elevation / scale.sweep->elevation_ratio, g};
}

/// The number of columns of voxels in a turn of a sweep, which is even. They are numbered from -columns / 2 on.
inline std::int32_t columns_of_turn(const VoxelScale& scale) {
  return 2 * math::floor_to_int(math::kPi / scale.voxel + 0.5);
}

/// Takes voxels (V flags) out of the grid, as if their points had not been selected. CANCELLED, DEADLINE_EXCEEDED.
absl::Status remove_voxels(const FrameContext& frame, const std::vector<bool>& removed, VoxelGrid& grid);

}  // namespace segserve
