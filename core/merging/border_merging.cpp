// SPDX-License-Identifier: Apache-2.0
#include "core/merging/border_merging.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {

absl::Status BorderMerging::run(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                                const RegionGraph& graph, MergeTree& tree) {
  const BorderConstants constants;
  RETURN_IF_ERROR(measure_borders(frame, graph, grid, normals, constants.dead_zone, borders_));
  std::vector<BorderEvidence> evidence;
  RETURN_IF_ERROR(find_border_evidence(frame, graph, borders_, constants, evidence));
  BorderMetric metric(graph, std::move(evidence), frame.options.min_segment_points, constants);
  return merger_.run(frame, graph.edges, small_region_threshold(frame.options), metric, tree);
}

}  // namespace segserve
