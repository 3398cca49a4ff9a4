// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

struct BridgingOptions {
  std::uint32_t voxels = 33;  ///< a connected component of fewer is small, and looks for others
  int reach = 4;              ///< how far a small component looks at most, voxels
};

/// Joins connected components that sampling tore apart: where a surface is sparser than the voxels, its voxels do not
/// touch one another. Makes the voxels of small components neighbors of voxels of other components at most 2 voxels
/// away (in the largest of the three directions). A component that is small still looks 3 voxels far, and so on up to
/// `reach`. A gap between two larger components stays. What is small even then in a CAMERA view, as pixels are that fly
/// between two surfaces, joins the nearest thing before or behind it (link_islands_by_depth).
/// O(V + E), and O(reach^2) for each voxel of a small component, or O(reach^2 log V) where such voxels are rare.
/// CANCELLED, DEADLINE_EXCEEDED.
absl::Status bridge_components(const FrameContext& frame, const VoxelGrid& grid, const BridgingOptions& options,
                               VoxelAdjacency& adjacency);

}  // namespace segserve
