#pragma once

#include <vector>

#include "core/math/vec3.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Which voxels (V) of a WORLD view can be seen from `sensor`: in its direction, no voxel is nearer to the sensor by
/// more than two voxels. Voxels count as balls of their own size on a cube of directions, 512 cells an edge. If
/// stopped, what it found is useless.
std::vector<bool> seen_from(const Vec3& sensor, const VoxelGrid& grid, double voxel_resolution,
                            const StopToken& stop = {});

}  // namespace segserve
