// SPDX-License-Identifier: Apache-2.0
#include "core/support_plane/support_plane_removal.hpp"

#include "core/base/status_macros.hpp"

namespace segserve {

absl::Status SupportPlaneRemoval::run(const FrameContext& frame, VoxelGrid& grid, VoxelAdjacency& adjacency,
                                      SupportPlane& plane) {
  RETURN_IF_ERROR(two_ring_normals_.run(frame, grid, adjacency, normals_));
  RETURN_IF_ERROR(find_support_plane(frame, grid, adjacency, normals_, found_));
  plane = found_.plane;
  RETURN_IF_ERROR(remove_voxels(frame, found_.member, grid));
  return find_adjacency(frame, grid, adjacency);
}

}  // namespace segserve
