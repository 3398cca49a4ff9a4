// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/base/frame_context.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/weights/border_metric.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve {

/// Lessens the evidence between parts of one thing that meet at a concave border.
///
/// The back of a chair meets its seat along the whole width of both, as the boards and sides of a shelf do, and the
/// inside of a bowl and its bottom. What stands on something else seldom reaches from one of its edges to the other. So
/// a border that spans both of its segments counts for little if they have one color. Without color it does so only in
/// a cloud that no camera or LiDAR saw from one place, because things that hide each other meet at such borders, too.
/// Segments of more than a twentieth of the scene are left alone: walls and floors meet at such borders.
///
/// `cut` is a first partition of the graph's regions, and `evidence` has an entry for each of its edges. Returns
/// whether any evidence has changed. O(V + E log E) for V voxels. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<bool> lessen_spanning_borders(const FrameContext& frame, const VoxelGrid& grid,
                                             const Supervoxels& supervoxels, const RegionGraph& graph, const Cut& cut,
                                             std::vector<BorderEvidence>& evidence);

}  // namespace segserve
