#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Sides for normals without a sensor: along a minimum spanning tree that prefers parallel normals (Hoppe et al. 1992),
/// each takes the side of its parent, and each connected component points upwards (+z) on the whole.
/// CANCELLED, DEADLINE_EXCEEDED.
absl::Status orient_consistently(const VoxelAdjacency& adjacency, const StopToken& stop, std::vector<Vec3>& normals);

/// A WORLD cloud that is fused from many views has one sensor position all the same, from which not every surface can
/// have been seen. Normals (V), turned to the sensor of `view`, keep their side where the sensor sees the voxel and all
/// its neighbours, and not at a grazing angle; the others take it over from those, along a minimum spanning forest
/// that prefers parallel normals. A component without any such voxel faces the sensor on the whole.
/// Clouds of a single view hardly change. CANCELLED, DEADLINE_EXCEEDED.
absl::Status orient_hidden(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                           double voxel_resolution, const StopToken& stop, std::vector<Vec3>& normals);

}  // namespace segserve
