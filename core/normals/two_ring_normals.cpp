// SPDX-License-Identifier: Apache-2.0
#include "core/normals/two_ring_normals.hpp"

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/normals/normal_orientation.hpp"
#include "core/voxels/voxel_blocks.hpp"

namespace segserve {

// Let A be the adjacency with each voxel as a neighbor of itself, and M the moments of single centroids. Then the two
// rings have the moments M + A M + A (A M), which takes two sparse passes instead of a visit to up to 729 voxels for
// each voxel. Moments are about the voxel's own centroid, which keeps them exact far from the origin.
absl::Status TwoRingNormals::run(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                 std::vector<Vec3>& normals) {
  const NormalKernels& kernels = normal_kernels();
  const NeighborRows rows{adjacency.offset.data(), adjacency.neighbor.data()};
  centroid_.resize(grid.size());
  rings_.resize(grid.size());
  normals.resize(grid.size());
  StopCheck check(frame.stop);
  check.for_each(0, grid.size(), [&](std::size_t v) {
    const Vec3& c = grid.centroid[v];
    centroid_[v] = {c.x, c.y, c.z, 0};
  });
  RETURN_IF_ERROR(check.status());
  RETURN_IF_ERROR(for_voxel_blocks(frame, adjacency, [&](std::size_t first, std::size_t last) {
    kernels.ring_moments(first, last, rows, centroid_.data(), rings_.data());
  }));
  RETURN_IF_ERROR(for_voxel_blocks(frame, adjacency, [&](std::size_t first, std::size_t last) {
    kernels.fit_planes(first, last, rows, centroid_.data(), rings_.data(), normals.data());
    turn_to_sensors(frame, grid, first, last, normals);
  }));
  return frame.view().has_sensor() ? absl::OkStatus() : orient_upwards(frame, adjacency, normals);
}

}  // namespace segserve
