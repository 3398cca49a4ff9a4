// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Makes the voxels at both ends of a LiDAR's turn neighbors of one another, as they are in the scene: its columns
/// begin and end behind the sensor, at -x. Does nothing to other clouds. O(V). CANCELLED, DEADLINE_EXCEEDED.
absl::Status join_seam(const FrameContext& frame, const VoxelGrid& grid, VoxelAdjacency& adjacency);

}  // namespace segserve
