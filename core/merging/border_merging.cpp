// SPDX-License-Identifier: Apache-2.0
#include "core/merging/border_merging.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/merging/noisy_planes.hpp"
#include "core/merging/small_region_threshold.hpp"
#include "core/merging/spanning_borders.hpp"

namespace segserve {
namespace {

constexpr double kUsualThreshold = 0.5;  // of the cut whose segments are looked at
constexpr int kMostRounds = 3;

BorderConstants constants_for(const FrameContext& frame) {
  constexpr double kSmallestOfSweep = 8;  // voxels; far people have few rays
  constexpr double kWallWeight = 3;
  BorderConstants constants;
  if (frame.scale.sweep) constants.smallest_size = kSmallestOfSweep;
  if (!frame.has_hidden_parts()) constants.wall_weight = kWallWeight;
  return constants;
}

/// Sets the points of a tree whose merges do not depend on them.
void count_points(const RegionGraph& graph, MergeTree& tree) {
  const std::size_t leaves = tree.leaf_count();
  for (std::size_t r = 0; r < leaves; ++r) tree.leaf_points[r] = graph.regions[r].points;
  const auto points_of = [&](std::uint32_t node) {
    return node < leaves ? tree.leaf_points[node] : tree.points[node - leaves];
  };
  for (std::size_t row = 0; row < tree.row_count(); ++row) {
    tree.points[row] = points_of(tree.left[row]) + points_of(tree.right[row]);
  }
}

}  // namespace

absl::Status BorderMerging::find_evidence(const FrameContext& frame, const VoxelGrid& grid,
                                          const std::vector<Vec3>& normals, const Supervoxels& supervoxels,
                                          const RegionGraph& graph) {
  const BorderConstants constants = constants_for(frame);
  RETURN_IF_ERROR(measure_borders(frame, graph, grid, normals, constants.dead_zone, borders_));
  RETURN_IF_ERROR(find_border_evidence(frame, graph, borders_, constants, evidence_));
  ASSIGN_OR_RETURN(tree_, merge(frame, graph, evidence_));
  ASSIGN_OR_RETURN(Cut cut, cut_at_threshold(tree_, kUsualThreshold, frame.stop));
  if (has_noisy_regions(frame, graph)) {
    ASSIGN_OR_RETURN(const bool has_changed, forgive_noisy_planes(frame, grid, supervoxels, graph, cut, evidence_));
    if (has_changed) {
      ASSIGN_OR_RETURN(tree_, merge(frame, graph, evidence_));
      ASSIGN_OR_RETURN(cut, cut_at_threshold(tree_, kUsualThreshold, frame.stop));
    }
  }
  // Parts that have become one meet others along wider borders.
  for (int round = 0; round < kMostRounds; ++round) {
    ASSIGN_OR_RETURN(const bool has_changed, lessen_spanning_borders(frame, grid, supervoxels, graph, cut, evidence_));
    if (!has_changed) break;
    ASSIGN_OR_RETURN(tree_, merge(frame, graph, evidence_));
    ASSIGN_OR_RETURN(cut, cut_at_threshold(tree_, kUsualThreshold, frame.stop));
  }
  return absl::OkStatus();
}

absl::Status BorderMerging::run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree) {
  if (frame.options.min_segment_points > 0) {
    ASSIGN_OR_RETURN(tree_, merge(frame, graph, std::move(evidence_)));
  } else {
    count_points(graph, tree_);
  }
  tree = std::move(tree_);
  return absl::OkStatus();
}

absl::StatusOr<MergeTree> BorderMerging::merge(const FrameContext& frame, const RegionGraph& graph,
                                               std::vector<BorderEvidence> evidence) {
  BorderMetric metric(graph, std::move(evidence), frame.options.min_segment_points, constants_for(frame));
  MergeTree tree;
  RETURN_IF_ERROR(merger_.run(frame, graph.edges, small_region_threshold(frame.options), metric, tree));
  return tree;
}

}  // namespace segserve
