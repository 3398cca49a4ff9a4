// SPDX-License-Identifier: Apache-2.0
#include "core/merging/border_merging.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {
namespace {

BorderConstants constants_for(const VoxelScale& scale) {
  constexpr double kSmallestOfSweep = 8;  // voxels; far people have few rays
  BorderConstants constants;
  if (scale.sweep) constants.smallest_size = kSmallestOfSweep;
  return constants;
}

}  // namespace

absl::Status BorderMerging::find_evidence(const FrameContext& frame, const VoxelGrid& grid,
                                          const std::vector<Vec3>& normals, const RegionGraph& graph) {
  const BorderConstants constants = constants_for(frame.scale);
  RETURN_IF_ERROR(measure_borders(frame, graph, grid, normals, constants.dead_zone, borders_));
  return find_border_evidence(frame, graph, borders_, constants, evidence_);
}

absl::Status BorderMerging::run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree) {
  BorderMetric metric(graph, std::move(evidence_), frame.options.min_segment_points, constants_for(frame.scale));
  return merger_.run(frame, graph.edges, small_region_threshold(frame.options), metric, tree);
}

}  // namespace segserve
