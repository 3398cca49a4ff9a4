// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Sets `positions` (V) to the centroids in the space in which supervoxels measure distances: that of voxels
/// (to_voxel_space) if the scale is in proportion to z. Otherwise it is the cloud's own frame; `positions` is then
/// cleared, because the centroids serve. CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_positions(const FrameContext& frame, const VoxelGrid& grid, std::vector<Vec3>& positions);

}  // namespace segserve
