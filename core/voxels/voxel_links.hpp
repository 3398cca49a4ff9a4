// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/voxel_adjacency.hpp"

namespace segserve {

/// Two voxels that are to be neighbors though their cells are not.
struct VoxelLink {
  std::uint32_t from, to;
  auto operator<=>(const VoxelLink&) const = default;
};

/// Makes both ends of each link neighbors of one another. They must not be neighbors yet; a link may come twice, and in
/// both directions. Leaves off when `check` stops it.
void add_links(const std::vector<VoxelLink>& links, StopCheck& check, VoxelAdjacency& adjacency);

}  // namespace segserve
