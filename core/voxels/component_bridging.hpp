#pragma once

#include "absl/status/status.h"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// What is an island, and how far it looks for land.
struct IslandOptions {
  double area = 12e-4;  ///< m^2; a connected component of less is an island
  int reach = 4;        ///< voxels
};

/// Where a surface is sparser than the voxels, its voxels do not touch one another. Makes the voxels of islands
/// neighbours of those of other components at most 2 voxels away (in the largest of the three directions); what is an
/// island still then looks 3 voxels far, and so on up to `reach`. Larger components stay as they are: a gap
/// between two of them is one. O(V + E), and O(reach^2 log V) for a voxel of an island. CANCELLED, DEADLINE_EXCEEDED.
absl::Status bridge_islands(const VoxelGrid& grid, const View& view, double voxel_resolution,
                            const IslandOptions& options, const StopToken& stop, VoxelAdjacency& adjacency);

}  // namespace segserve
