// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Finds which voxels (V) of a WORLD view its sensor, whose position must be known, can see: in the direction of a
/// visible voxel, no other voxel is nearer to the sensor by more than two voxels. Voxels count as balls of their own
/// size on a cube of directions with 512 cells an edge. O(V). CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_visible_voxels(const FrameContext& frame, const VoxelGrid& grid, std::vector<bool>& visible);

}  // namespace segserve
