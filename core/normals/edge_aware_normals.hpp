// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/normals/neighborhoods.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// The normals of the border method, which are not averaged across edges. Keeps its buffers between frames.
class EdgeAwareNormals {
 public:
  /// Sets `normals` (V) to unit normals, or to the zero vector where no plane is defined: fits normals to the
  /// neighborhoods (fit_neighborhood_normals), corrects the sides of those that a known sensor of a WORLD view cannot
  /// have seen (orient_hidden_normals), and refines them (refine_normals). CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                   std::vector<Vec3>& normals);

 private:
  Neighborhoods neighborhoods_;
};

/// Sets `normals` (V) to those of the planes that fit the centroids of all voxels in the neighborhoods, each weighted
/// by
///     max(0, 1 - (d / 3.2)^2)^2,
/// where d is its distance in voxels. A normal is the zero vector where no plane is defined. Normals are turned towards
/// the sensor, or made consistent in a view without one (orient_consistently). CANCELLED, DEADLINE_EXCEEDED.
absl::Status fit_neighborhood_normals(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                      const Neighborhoods& neighborhoods, std::vector<Vec3>& normals);

/// How refine_normals weighs a neighbor.
struct RefinementOptions {
  double angle = 20;     ///< between the first normals, at which the weight has fallen to 1/e, degrees
  double offset = 0.25;  ///< standard deviation of the distance from the plane of the other voxel, voxels
  double support = 2.5;  ///< a voxel keeps its first normal if the sum of weights is not above this
};

/// Refits the plane of each voxel to the centroids of all voxels in its neighborhood, itself included, weighted by
///     exp(-2 (1 - cos T) / angle^2 - min(ov^2, ou^2) / (2 (offset voxel)^2)).
/// T is the angle between the first normals of the two voxels, `angle` is in radians, and ov and ou are the distances
/// of each centroid from the plane through the other one. `normals` (V) holds the first normals, turned to one side,
/// and gets the new ones on the same side. In a CAMERA view the size of a voxel is voxel_resolution * z. Overwrites the
/// normals of `neighborhoods`. CANCELLED, DEADLINE_EXCEEDED.
absl::Status refine_normals(const FrameContext& frame, const RefinementOptions& options, Neighborhoods& neighborhoods,
                            std::vector<Vec3>& normals);

}  // namespace segserve
