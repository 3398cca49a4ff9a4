#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/radix_sort.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/point_selection.hpp"
#include "core/voxels/range_voxelizer.hpp"
#include "core/voxels/voxel_key.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// The occupied voxels of a cloud, in ascending order of their keys. The grid's origin is fixed, and
/// sums are taken in integers: voxels depend neither on the order of the points nor on threads.
struct VoxelGrid {
  std::vector<VoxelKey> key;          ///< V
  std::vector<Vec3> centroid;         ///< V: mean of the voxel's points, metres, the cloud's frame
  std::vector<Vec3> color_sum;        ///< V: sum of (R, G, B), 0..255 each, over its points; whole numbers
  std::vector<std::uint32_t> points;  ///< V: number of its points
  /// N: every point's slot, in order of first appearance; 0 for a point that is not finite, or not selected.
  std::vector<std::uint32_t> slot_of_point;
  /// The voxel of every slot, kNoVoxel for those removed, [0] unused: a value per voxel becomes one per point by one
  /// gather.
  std::vector<std::uint32_t> voxel_of_slot;
  std::size_t finite_points = 0;  ///< of the cloud, selected or not

  std::size_t size() const { return key.size(); }
};

inline constexpr std::uint32_t kNoVoxel = ~std::uint32_t{0};

/// Edge of a voxel at `position`, metres: in a CAMERA view it grows with the distance.
inline double voxel_edge(double resolution, const View& view, const Vec3& position) {
  return view.kind == ViewKind::kCamera ? resolution * position.z : resolution;
}

/// Buffers of `voxelize` that are worth keeping between calls.
struct VoxelizeScratch {
  std::vector<VoxelPart> parts;       ///< of each thread
  std::vector<std::uint64_t> ranked;  ///< V: keys without the bits that all share
  std::vector<std::uint32_t> order;   ///< V
  math::SortScratch sort;
};

/// Sorts the finite points of the selection into voxels of edge `resolution` (metres; in a CAMERA view the cells are
/// cubes of (x/z, y/z, ln z), so the edge is resolution * z).
/// INVALID_ARGUMENT, naming the first such point of the selection: z <= 0 in a CAMERA view, or a coordinate beyond
/// the grid (about 2^18 voxels from the origin). CANCELLED, DEADLINE_EXCEEDED.
absl::Status voxelize(const CloudView& cloud, double resolution, unsigned threads, const StopToken& stop,
                      VoxelizeScratch& scratch, VoxelGrid& grid, const Selection& selection = {});

/// Takes voxels (V flags) out of the grid, as if their points had not been selected. If
/// stopped, the grid is useless.
void remove_voxels(const std::vector<bool>& removed, const StopToken& stop, VoxelGrid& grid);

}  // namespace segserve
