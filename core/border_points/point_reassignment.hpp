// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/border_points/border_voxels.hpp"
#include "core/border_points/supervoxel_surface.hpp"
#include "core/math/vec3.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/weights/border_metric.hpp"

namespace segserve {

/// A point that belongs to another supervoxel than the voxel in which it lies.
struct ReassignedPoint {
  std::uint32_t point, supervoxel;
  bool operator==(const ReassignedPoint&) const = default;
};

/// Draws the borders between objects point by point. Supervoxels are made of whole voxels, and where two objects touch
/// a voxel holds points of both. So each point in a voxel at a border (BorderVoxels) is given to the supervoxel across
/// the border if that fits it clearly better than the supervoxel s of its voxel:
///
///     misfit(s) - misfit(t) + 2 (T - S) / (T + S) > 0.2.
///
/// The misfit is the distance of the point from the plane of a supervoxel (SupervoxelSurface), and t is the supervoxel
/// across the border with the smallest misfit. S and T are the points in the voxels around the point on either side of
/// the border, each voxel weighted by 1 - (d / 2)^2, where d is the distance of its centroid in edges of a voxel. They
/// keep the border smooth where noise exceeds what the planes tell.
///
/// Color does not count: the colors of depth cameras are often a few pixels off. Only the points of the regions and the
/// sums of their colors change; voxels, planes, edges and evidence stay. A supervoxel gives points away only if one of
/// its voxels lies at no border, so that none is left without points. Every point is judged for itself, by sums over
/// voxels, so that neither the order of the points nor the number of threads matters. Keeps its buffers between frames.
class PointReassignment {
 public:
  /// Sets `reassigned` in the order of the points, and moves these points between the regions of the graph. `positions`
  /// are those from which the supervoxels grew, and `evidence` has an entry for each edge. O(V + N) for V voxels and N
  /// points. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& positions,
                   const VoxelAdjacency& adjacency, const Supervoxels& supervoxels,
                   const std::vector<BorderEvidence>& evidence, RegionGraph& graph,
                   std::vector<ReassignedPoint>& reassigned);

 private:
  BorderVoxels border_;
  std::vector<SupervoxelSurface> surfaces_;          // m
  std::vector<std::uint32_t> voxel_of_slot_;         // of voxels at a border; else kNoVoxel
  std::vector<std::vector<ReassignedPoint>> parts_;  // what each thread found
};

}  // namespace segserve
