#pragma once

#include <vector>

#include "core/math/vec3.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/support_plane.hpp"

namespace segserve {

struct PlaneVoxels {
  SupportPlane plane;
  std::vector<bool> member;  ///< V: belongs to the plane
};

/// Finds the plane that supports the objects, a table or the floor: of the planes that hold a tenth of all voxels or
/// more
/// - in a CAMERA view the one of most voxels that faces up if the camera stands upright (y down; its roll at most 30
///   degrees, and it looks down, or up by less than 10 degrees); if there is none, as below a camera that looks
///   straight down, the one of most voxels;
/// - in a WORLD view the one of most voxels that faces up, at most 30 degrees off +z. Without the position of the
///   sensor it is not known which side of a surface is seen, and a ceiling may be taken for a floor.
///
/// `normals` (V): turned to one side (compute_normals). `distance`: how far from the plane its points may be, metres;
/// in a CAMERA view at 1 m distance, in proportion to z elsewhere. A voxel belongs to the plane if its centroid is
/// that near and its normal agrees, or, beside such voxels, where normals reach across edges, if it is half as
/// far: so objects keep their sides. What is below the plane, and what it would cut through, is left alone.
///
/// Random sample consensus over the voxels in their order, so that the same voxels give the same plane. If stopped,
/// what it found is useless.
PlaneVoxels find_support_plane(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                               const View& view, double distance, const StopToken& stop = {});

}  // namespace segserve
