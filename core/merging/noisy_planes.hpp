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

/// Whether any region of a CAMERA view lies where noise exceeds a voxel (VoxelScale::noise_depth).
bool has_noisy_regions(const FrameContext& frame, const RegionGraph& graph);

/// Takes the evidence from edges within a plane that only the noise of a camera makes uneven.
///
/// Where noise exceeds a voxel, normals tell little, and a far wall comes out in patches. But many voxels together tell
/// a plane well: it is a plane in (x/z, y/z, 1/z), too, and there the noise is the same at any depth. Segments that lie
/// so far away, the largest first, gather neighbors that the same plane explains within the noise.
///
/// `cut` is a first partition of the graph's regions in a CAMERA view, and `evidence` has an entry for each of its
/// edges. Returns whether any evidence was taken. O(V + E log E). CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<bool> forgive_noisy_planes(const FrameContext& frame, const VoxelGrid& grid,
                                          const Supervoxels& supervoxels, const RegionGraph& graph, const Cut& cut,
                                          std::vector<BorderEvidence>& evidence);

}  // namespace segserve
