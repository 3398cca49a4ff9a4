// SPDX-License-Identifier: Apache-2.0
#include "core/merging/paper_merging.hpp"

#include "core/base/status_macros.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {

absl::Status PaperMerging::run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree, double& lambda) {
  ASSIGN_OR_RETURN(PaperMetric metric, PaperMetric::create(frame, graph));
  lambda = metric.lambda();
  return merger_.run(frame, graph.edges, small_region_threshold(frame.options), metric, tree);
}

}  // namespace segserve
