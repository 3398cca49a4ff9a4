// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/voxels/voxel_links.hpp"

namespace segserve {

/// A voxel of a small component that touches no other one.
struct IslandVoxel {
  std::uint32_t voxel = 0, component = 0;
};

/// Links each island of a CAMERA view with the voxel that is nearest in depth, before it or behind it, in the columns
/// of voxels at most two from its own. Pixels fly between two surfaces on the rays past the edge of the one in front,
/// where a camera of time of flight mixes their distances. `islands` are all of them, by ascending voxels. Islands are
/// not linked with one another, nor with what is beside them. O(V), and O(I log I) for I voxels in islands.
void link_islands_by_depth(const VoxelGrid& grid, const std::vector<IslandVoxel>& islands, StopCheck& check,
                           std::vector<VoxelLink>& links);

}  // namespace segserve
