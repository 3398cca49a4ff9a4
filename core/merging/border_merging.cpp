// SPDX-License-Identifier: Apache-2.0
#include "core/merging/border_merging.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {

absl::Status BorderMerging::find_evidence(const FrameContext& frame, const VoxelGrid& grid,
                                          const std::vector<Vec3>& normals, const RegionGraph& graph) {
  const BorderConstants constants;
  RETURN_IF_ERROR(measure_borders(frame, graph, grid, normals, constants.dead_zone, borders_));
  return find_border_evidence(frame, graph, borders_, constants, evidence_);
}

absl::Status BorderMerging::run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree) {
  BorderMetric metric(graph, std::move(evidence_), frame.options.min_segment_points, {});
  return merger_.run(frame, graph.edges, small_region_threshold(frame.options), metric, tree);
}

}  // namespace segserve
