// SPDX-License-Identifier: Apache-2.0
#include "segserve/stability.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/base/status_macros.hpp"

namespace segserve {

std::vector<ThresholdRange> threshold_ranges(const MergeTree& tree) {
  const std::size_t m = tree.leaf_count();
  std::vector<ThresholdRange> ranges(m + tree.row_count(), {0, 1});
  for (std::size_t row = 0; row < tree.row_count(); ++row) {
    if (tree.kind[row] == MergeKind::kJoined) {
      ranges[m + row] = {1, 1};
      continue;
    }
    ranges[m + row].from = ranges[tree.left[row]].to = ranges[tree.right[row]].to = tree.height[row];
  }
  return ranges;
}

absl::StatusOr<std::vector<std::uint32_t>> segment_nodes(const MergeTree& tree, std::uint32_t regions,
                                                         const StopToken& stop) {
  ASSIGN_OR_RETURN(const Cut cut, cut_to_regions(tree, regions, stop));
  const std::size_t m = tree.leaf_count();
  // The segment of every node that the cut has made. The node that was made last holds the others of its segment.
  std::vector<std::uint32_t> segment(cut.segment_of_leaf);
  std::vector<std::uint32_t> nodes(cut.segments);
  for (std::uint32_t leaf = 0; leaf < m; ++leaf) nodes[segment[leaf] - 1] = leaf;
  for (std::size_t row = 0; row < m - cut.segments; ++row) {
    segment.push_back(segment[tree.left[row]]);
    nodes[segment.back() - 1] = static_cast<std::uint32_t>(m + row);
  }
  return nodes;
}

}  // namespace segserve
