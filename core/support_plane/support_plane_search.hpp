// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/support_plane.hpp"

namespace segserve {

struct PlaneVoxels {
  SupportPlane plane;
  std::vector<bool> member;  ///< V: whether the voxel belongs to the plane
};

/// Finds the plane that supports the objects, a table or the floor, among the planes that hold a tenth of all voxels or
/// more:
/// - In a CAMERA view it is the plane of most voxels among those that face up if the camera stands upright (y down; its
///   roll is at most 30 degrees, and it looks down, or up by less than 10 degrees). If there is none, as below a camera
///   that looks straight down, it is the plane of most voxels.
/// - In a WORLD view it is the plane of most voxels among those that face up, at most 30 degrees off +z. Without the
///   position of the sensor it is not known which side of a surface is seen, and a ceiling may be taken for a floor.
///
/// `normals` (V) must be turned to one side (TwoRingNormals). The option support_plane_distance must be set. A voxel
/// belongs to the plane if its centroid is at most that far from it and its normal agrees. Beside such voxels, where
/// normals reach across edges, a voxel belongs to it if it is at most half as far, whatever its normal. So objects keep
/// their sides. What is below the plane, and what the plane would cut through, does not belong to it.
///
/// This is random sample consensus over the voxels in their order, so that the same voxels give the same plane.
/// CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_support_plane(const FrameContext& frame, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                const std::vector<Vec3>& normals, PlaneVoxels& found);

}  // namespace segserve
