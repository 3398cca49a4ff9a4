// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Sets `grid.camera`, to nothing if the view has no cameras. The camera that saw a voxel is the one with most of its
/// points. If several have as many, it is the nearest of them, or else the first. The order of each camera's points
/// does not matter. O(N + V C) for C cameras. CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_seeing_cameras(const FrameContext& frame, VoxelGrid& grid);

}  // namespace segserve
