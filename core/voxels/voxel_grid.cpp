// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxel_grid.hpp"

#include "core/base/stop_check.hpp"

namespace segserve {

absl::Status remove_voxels(const FrameContext& frame, const std::vector<bool>& removed, VoxelGrid& grid) {
  StopCheck check(frame.stop);
  std::vector<std::uint32_t> moved_to(grid.size(), kNoVoxel);
  std::uint32_t left = 0;
  check.for_each(0, grid.size(), [&](std::size_t v) {
    if (removed[v]) return;
    grid.key[left] = grid.key[v];
    grid.centroid[left] = grid.centroid[v];
    grid.color_sum[left] = grid.color_sum[v];
    grid.points[left] = grid.points[v];
    if (!grid.camera.empty()) grid.camera[left] = grid.camera[v];
    moved_to[v] = left++;
  });
  grid.key.resize(left);
  grid.centroid.resize(left);
  grid.color_sum.resize(left);
  grid.points.resize(left);
  if (!grid.camera.empty()) grid.camera.resize(left);
  check.for_each(1, grid.voxel_of_slot.size(),
                 [&](std::size_t slot) { grid.voxel_of_slot[slot] = moved_to[grid.voxel_of_slot[slot]]; });
  return check.status();
}

}  // namespace segserve
