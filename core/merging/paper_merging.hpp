// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/merging/merger.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/weights/paper_metric.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve {

/// Merges the regions of a graph by the paper's metric delta (eq. 3). Keeps its buffers between frames.
class PaperMerging {
 public:
  /// Sets the merge tree, and the weight of color against geometry that was used (`lambda`, which Adaptive Lambda
  /// finds). CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree, double& lambda);

 private:
  Merger<PaperMetric> merger_;
};

}  // namespace segserve
