// SPDX-License-Identifier: Apache-2.0
#include "core/merging/border_merging.hpp"

#include "core/base/status_macros.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {

absl::Status BorderMerging::run(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                                const Supervoxels& supervoxels, const RegionGraph& graph, MergeTree& tree) {
  const BorderOptions constants;
  measure_borders(graph, grid, normals, supervoxels, constants.dead_zone, frame.stop, borders_);
  RETURN_IF_ERROR(frame.stop.check());
  const std::vector<BorderMetric::Evidence> evidence = border_evidence(
      graph, borders_, frame.settings.voxel_resolution, frame.settings.seed_resolution, constants, frame.stop);
  RETURN_IF_ERROR(frame.stop.check());
  BorderMetric metric(graph, frame.options.min_segment_points, constants);
  ASSIGN_OR_RETURN(tree, merge_regions<BorderMetric>(graph.edges, evidence, small_region_threshold(frame.options),
                                                     metric, frame.stop, scratch_));
  return absl::OkStatus();
}

}  // namespace segserve
