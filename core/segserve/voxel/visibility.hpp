#pragma once

#include <vector>

#include "segserve/math/vec3.hpp"
#include "segserve/pipeline/stop_token.hpp"
#include "segserve/voxel/voxel_grid.hpp"

namespace segserve {

/// Which voxels (V) of a WORLD view can be seen from `sensor`: in its direction, no voxel is nearer to the sensor by
/// more than two voxels. Voxels count as balls of their own size on a cube of directions, 512 cells an edge. If
/// stopped, what it found is useless.
std::vector<bool> seen_from(const Vec3& sensor, const VoxelGrid& grid, double voxel_resolution,
                            const StopToken& stop = {});

}  // namespace segserve
