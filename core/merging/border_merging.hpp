// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/frame_context.hpp"
#include "core/math/vec3.hpp"
#include "core/merging/merger.hpp"
#include "core/region_graph/borders.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/weights/border_metric.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve {

/// Merges the regions of a graph by the evidence along the borders between their supervoxels. Keeps its buffers between
/// frames.
class BorderMerging {
 public:
  /// Finds the evidence of all edges of the graph. That within far planes which are uneven only by the noise of a
  /// camera does not count (forgive_noisy_planes), and that between parts of one thing counts less
  /// (lessen_spanning_borders). Both look at the segments of a merge, after which
  /// the regions are merged anew. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status find_evidence(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                             const Supervoxels& supervoxels, const RegionGraph& graph);
  const std::vector<BorderEvidence>& evidence() const { return evidence_; }

  /// Sets the merge tree of the graph whose evidence was found. Only the points of its regions may have changed since.
  /// Uses the evidence up. CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree);

 private:
  absl::StatusOr<MergeTree> merge(const FrameContext& frame, const RegionGraph& graph,
                                  std::vector<BorderEvidence> evidence);

  std::vector<Border> borders_;
  std::vector<BorderEvidence> evidence_;
  MergeTree tree_;  // by the evidence so far
  Merger<BorderMetric> merger_;
};

}  // namespace segserve
