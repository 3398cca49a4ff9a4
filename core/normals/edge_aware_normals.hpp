#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/math/vec3.hpp"
#include "core/normals/neighborhoods.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// The first normals (V) of refine_normals: the plane that fits the centroids of all voxels in a voxel's window, each
/// weighted by
///     max(0, 1 - (d / 3.2)^2)^2,
/// d its distance in voxels. The zero vector where no plane is defined. Turned as by compute_normals, along `adjacency`
/// in a view without a sensor. CANCELLED, DEADLINE_EXCEEDED.
absl::Status window_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                            const StopToken& stop, const VoxelWindows& windows, std::vector<Vec3>& normals);

/// How `refine_normals` weighs a neighbour.
struct EdgeAwareOptions {
  double angle = 20;     ///< between the first normals at which the weight has fallen to 1/e, degrees
  double offset = 0.25;  ///< standard deviation of the distance from the other's plane, voxels
  double support = 2.5;  ///< sum of weights below which the first normal stays
};

/// Normals that are not averaged across edges: refits each voxel's plane to the centroids of all voxels in its window
/// (itself included), weighted by
///     exp(-(T / angle)^2 - min(ov^2, ou^2) / (2 (offset voxel)^2)),
/// T the angle between the first normals, ov and ou the distances of each centroid from the plane through the
/// other. `normals` (V) holds the first normals, turned to one side, and gets the new ones on the same side.
/// In a CAMERA view the size of a voxel is voxel_resolution * z. CANCELLED, DEADLINE_EXCEEDED.
absl::Status refine_normals(const EdgeAwareOptions& options, const StopToken& stop, VoxelWindows& windows,
                            std::vector<Vec3>& normals);

}  // namespace segserve
