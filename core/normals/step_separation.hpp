// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Parts neighbors between which there is a step, in a LiDAR's sweep. Its voxels are deeper than wide, so that a ground
/// seen at a grazing angle holds together; but what stands behind something else is then a neighbor of it, too. Two
/// voxels stay neighbors if they are within 1.5 heights of a voxel and half a meter, or if one lies on the plane of the
/// other: within half such a height and 15 cm. Does nothing to other clouds. `normals` has V entries, of length 1 or 0
/// where no plane is known. O(V). CANCELLED, DEADLINE_EXCEEDED.
absl::Status separate_steps(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                            VoxelAdjacency& adjacency);

}  // namespace segserve
