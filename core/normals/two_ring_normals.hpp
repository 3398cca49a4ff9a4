// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/normals/simd/normal_kernels.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Fits normals to the two rings of neighbors around each voxel, as PCL's SupervoxelClustering does. Keeps its buffers
/// between frames.
class TwoRingNormals {
 public:
  /// Sets `normals` (V) to unit normals: of the plane that fits the centroids of the voxel, of its neighbors and of
  /// their neighbors, each as often as a path leads to it. A normal is the zero vector where no plane is defined.
  /// Normals are turned towards the sensor, or made consistent in a view without one (orient_consistently).
  /// O(V + E). CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                   std::vector<Vec3>& normals);

 private:
  std::vector<PaddedVec3> centroid_;  // V
  std::vector<RingMoments> rings_;    // V
};

}  // namespace segserve
