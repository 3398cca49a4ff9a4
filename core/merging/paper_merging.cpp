// SPDX-License-Identifier: Apache-2.0
#include "core/merging/paper_merging.hpp"

#include <vector>

#include "core/base/status_macros.hpp"
#include "core/merging/small_region_threshold.hpp"

namespace segserve {

absl::Status PaperMerging::run(const FrameContext& frame, const RegionGraph& graph, MergeTree& tree, double& lambda) {
  PaperMetric metric(graph, frame.view(), frame.options, frame.stop);
  RETURN_IF_ERROR(frame.stop.check());
  lambda = metric.lambda();
  const std::vector<PaperMetric::Evidence> none(graph.edges.size());
  ASSIGN_OR_RETURN(tree, merge_regions<PaperMetric>(graph.edges, none, small_region_threshold(frame.options), metric,
                                                    frame.stop, scratch_));
  return absl::OkStatus();
}

}  // namespace segserve
