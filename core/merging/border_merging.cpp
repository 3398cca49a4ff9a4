// SPDX-License-Identifier: Apache-2.0
#include "core/merging/border_merging.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/merging/noisy_planes.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {
namespace {

constexpr double kUsualThreshold = 0.5;  // of the cut whose segments are looked at as planes

BorderConstants constants_for(const VoxelScale& scale) {
  constexpr double kSmallestOfSweep = 8;  // voxels; far people have few rays
  BorderConstants constants;
  if (scale.sweep) constants.smallest_size = kSmallestOfSweep;
  return constants;
}

}  // namespace

absl::Status BorderMerging::find_evidence(const FrameContext& frame, const VoxelGrid& grid,
                                          const std::vector<Vec3>& normals, const Supervoxels& supervoxels,
                                          const RegionGraph& graph) {
  const BorderConstants constants = constants_for(frame.scale);
  RETURN_IF_ERROR(measure_borders(frame, graph, grid, normals, constants.dead_zone, borders_));
  RETURN_IF_ERROR(find_border_evidence(frame, graph, borders_, constants, evidence_));
  if (!has_noisy_regions(frame, graph)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const MergeTree tree, merge(frame, graph, evidence_));
  ASSIGN_OR_RETURN(const Cut cut, cut_at_threshold(tree, kUsualThreshold, frame.stop));
  return forgive_noisy_planes(frame, grid, supervoxels, graph, cut, evidence_);
}

absl::Status BorderMerging::run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree) {
  ASSIGN_OR_RETURN(tree, merge(frame, graph, std::move(evidence_)));
  return absl::OkStatus();
}

absl::StatusOr<MergeTree> BorderMerging::merge(const FrameContext& frame, const RegionGraph& graph,
                                               std::vector<BorderEvidence> evidence) {
  BorderMetric metric(graph, std::move(evidence), frame.options.min_segment_points, constants_for(frame.scale));
  MergeTree tree;
  RETURN_IF_ERROR(merger_.run(frame, graph.edges, small_region_threshold(frame.options), metric, tree));
  return tree;
}

}  // namespace segserve
