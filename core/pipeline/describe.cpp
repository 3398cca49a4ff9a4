// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/base/stopwatch.hpp"
#include "segserve/segment.hpp"
#include "segserve/stability.hpp"

namespace segserve {
namespace {

/// Sets the thresholds at which the merge tree has the segments.
absl::Status set_thresholds(const MergeTree& tree, std::uint32_t segments, const StopToken& stop,
                            std::vector<SegmentStatistics>& statistics) {
  if (segments == 0) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<std::uint32_t> nodes, segment_nodes(tree, segments, stop));
  const std::vector<ThresholdRange> ranges = threshold_ranges(tree);
  for (std::size_t k = 0; k < std::min(nodes.size(), statistics.size()); ++k)
    statistics[k].thresholds = ranges[nodes[k]];
  return absl::OkStatus();
}

}  // namespace

absl::Status describe(const CloudView& cloud, unsigned threads, const StopToken& stop, Segmentation& segmentation) {
  Stopwatch watch;
  const std::uint32_t segments = std::min(segmentation.segments, kMostDescribedSegments);
  ASSIGN_OR_RETURN(std::vector<SegmentStatistics> statistics,
                   describe_segments(cloud, segmentation.labels, segments, threads, stop));
  if (!segmentation.supervoxel_normals.empty()) {
    std::vector<std::uint32_t> segment_of_leaf(segmentation.supervoxel_normals.size());
    StopCheck check(stop);
    check.for_each(0, cloud.size(), [&](std::size_t i) {
      const std::uint32_t supervoxel = segmentation.supervoxels[i];
      if (supervoxel > 0) segment_of_leaf[supervoxel - 1] = segmentation.labels[i];
    });
    RETURN_IF_ERROR(check.status());
    RETURN_IF_ERROR(set_normals(segmentation.supervoxel_normals, segment_of_leaf, statistics, stop));
  }
  if (segmentation.is_cut && segmentation.tree.leaf_count() > 0) {
    RETURN_IF_ERROR(set_thresholds(segmentation.tree, segmentation.segments, stop, statistics));
  }
  segmentation.statistics = std::move(statistics);
  segmentation.timings.segments = watch.lap();
  segmentation.timings.total += segmentation.timings.segments;
  return absl::OkStatus();
}

}  // namespace segserve
