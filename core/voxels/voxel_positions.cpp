// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxel_positions.hpp"

#include "core/base/stop_check.hpp"

namespace segserve {

absl::Status find_positions(const FrameContext& frame, const VoxelGrid& grid, std::vector<Vec3>& positions) {
  positions.clear();
  if (!frame.scale.in_proportion) return absl::OkStatus();
  positions.resize(grid.size());
  StopCheck check(frame.stop);
  check.for_each(0, grid.size(), [&](std::size_t v) { positions[v] = to_voxel_space(frame.scale, grid.centroid[v]); });
  return check.status();
}

}  // namespace segserve
