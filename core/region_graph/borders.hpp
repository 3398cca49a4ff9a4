// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/region_graph/region_graph.hpp"

namespace segserve {

/// The border between two adjacent supervoxels.
struct Border {
  double contacts = 0;   ///< the number of contacts across it, at least 1
  double concavity = 0;  ///< the mean angle, over the contacts, by which they are concave beyond the dead zone, degrees
};

/// The concavity that counts as none, degrees.
struct DeadZone {
  double angle = 0;  ///< everywhere
  double noise = 0;  ///< and so much more where the excess noise (VoxelScale) is 1
};

/// Measures the borders of all edges of the graph, in their order. A contact of voxels with normals n and centroids x
/// is concave if (na - nb) . (xa - xb) < 0, by the angle between the normals less the dead zone. Where a normal is not
/// defined the angle counts as 0. CANCELLED, DEADLINE_EXCEEDED.
absl::Status measure_borders(const FrameContext& frame, const RegionGraph& graph, const VoxelGrid& grid,
                             const std::vector<Vec3>& normals, const DeadZone& zone, std::vector<Border>& borders);

}  // namespace segserve
