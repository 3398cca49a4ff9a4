// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/support_plane/support_plane_search.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/support_plane.hpp"

namespace segserve {

/// Removes the plane that supports the objects from the voxels. Keeps its buffers between frames.
class SupportPlaneRemoval {
 public:
  /// Finds the plane by the normals of the two rings, takes its voxels out of the grid, and finds the adjacency of the
  /// others. The option support_plane_distance must be set. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, VoxelGrid& grid, VoxelAdjacency& adjacency, SupportPlane& plane);

 private:
  TwoRingNormals two_ring_normals_;
  std::vector<Vec3> normals_;
  PlaneVoxels found_;
};

}  // namespace segserve
