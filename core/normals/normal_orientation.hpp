// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"

namespace segserve {

/// Where the sensor of `view` is, which must have a single one (CAMERA, or WORLD with a position).
Vec3 sensor_of(const View& view);

/// Turns a normal at `position` towards the sensor. No branch asks for the side, because it would be mispredicted for
/// half of the voxels.
inline Vec3 turn_to_sensor(const Vec3& normal, const Vec3& position, const Vec3& sensor) {
  const double side = dot(normal, sensor - position);
  return std::copysign(1.0, side + 0.0) * normal;  // -0.0 + 0.0 is 0.0
}

/// Turns the normals (V) of the voxels from `first` to `last` towards the sensor, or to the camera that saw the voxel.
/// Leaves them in a view without a sensor.
void turn_to_sensors(const FrameContext& frame, const VoxelGrid& grid, std::size_t first, std::size_t last,
                     std::vector<Vec3>& normals);

/// Makes normals (V) consistent in a view without a sensor. Along a minimum spanning tree that prefers parallel normals
/// (Hoppe et al. 1992), each normal takes the side of its parent, and each connected component points upwards (+z) on
/// the whole. CANCELLED, DEADLINE_EXCEEDED.
absl::Status orient_upwards(const FrameContext& frame, const VoxelAdjacency& adjacency, std::vector<Vec3>& normals);

/// The same, but where floor and ceiling cancel one another, as in a closed room, a component points to the inside of
/// what is as large as a room, and to the outside of smaller things, unless the preset says which it is.
absl::Status orient_as_seen(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                            std::vector<Vec3>& normals);

/// Corrects normals (V) of a WORLD view that were turned to its sensor. A cloud that is fused from many views has one
/// sensor position all the same, from which not every surface can have been seen. A normal keeps its side where the
/// sensor sees the voxel and all its neighbors, and not at a grazing angle. The others take over the side of those,
/// along a minimum spanning forest that prefers parallel normals. A component without any such voxel faces the sensor
/// on the whole. Clouds of a single view hardly change. CANCELLED, DEADLINE_EXCEEDED.
absl::Status orient_hidden_normals(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                   std::vector<Vec3>& normals);

}  // namespace segserve
