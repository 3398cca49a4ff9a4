#pragma once

#include <cmath>
#include <vector>

#include "absl/status/status.h"
#include "core/math/vec3.hpp"
#include "core/normals/simd/normal_kernels.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Buffers of `compute_normals` that are worth keeping between calls.
struct NormalsScratch {
  std::vector<Quad> centroid;      ///< V
  std::vector<RingMoments> rings;  ///< V
};

/// Where the sensor of `view` is, which must have one (CAMERA, or WORLD with a position).
Vec3 sensor_of(const View& view);

/// Turns a normal at `position` towards the sensor. Without a branch, which half of the voxels would mispredict: 0.2 ms
/// of 12 a full frame.
inline Vec3 turn_to_sensor(const Vec3& normal, const Vec3& position, const Vec3& sensor) {
  const double side = dot(normal, sensor - position);
  return std::copysign(1.0, side + 0.0) * normal;  // -0.0 + 0.0 is 0.0
}

/// Unit normals of the voxels (V): the plane that fits the centroids of the voxel, its neighbours and
/// their neighbours, each as often as a path leads to it (as PCL's SupervoxelClustering does). The
/// zero vector where no plane is defined. Turned towards the sensor; in a WORLD view without one,
/// made consistent over each connected component, whose normals sum up to point upwards (+z).
absl::Status compute_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view, unsigned threads,
                             const StopToken& stop, NormalsScratch& scratch, std::vector<Vec3>& normals);

/// For those who do it once.
inline absl::Status compute_normals(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const View& view,
                                    unsigned threads, const StopToken& stop, std::vector<Vec3>& normals) {
  NormalsScratch scratch;
  return compute_normals(grid, adjacency, view, threads, stop, scratch, normals);
}

}  // namespace segserve
