// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/base/voxel_scale.hpp"
#include "core/math/vec3.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// The surface of a supervoxel: the plane through its centroid.
struct SupervoxelSurface {
  Vec3 centroid;      ///< meters
  Vec3 normal;        ///< a unit vector on the side from which the surface was seen; 0 if it is not defined
  double weight = 0;  ///< of a distance in front of the plane: 1 / (roughness + 0.1), where the roughness is the root
                      ///< mean square distance of the voxels from the plane, in edges of a voxel

  bool is_defined() const { return normal != Vec3{}; }

  /// How badly the surface explains a point, where voxels have this edge, meters. It is the distance from the plane in
  /// edges of a voxel, in front of it times `weight`. Behind it the distance counts half, because the surface of a
  /// convex object bends away from the sensor.
  double misfit(const Vec3& point, double edge) const {
    constexpr double kBehind = 0.5;
    const double height = dot(normal, point - centroid) / edge;
    return height > 0 ? weight * height : -kBehind * height;
  }
};

/// The edge of the voxels of the border method at `position`, meters.
inline double border_voxel_edge(const VoxelScale& scale, const Vec3& position) {
  return scale.in_proportion ? depth_of(scale, position) * scale.voxel : scale.voxel;
}

/// Finds the surfaces of all supervoxels (m). CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_surfaces(const FrameContext& frame, const RegionGraph& graph,
                           std::vector<SupervoxelSurface>& surfaces);

}  // namespace segserve
