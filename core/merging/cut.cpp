// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/radix_sort.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "fmt/format.h"
#include "segserve/merge_tree.hpp"

namespace segserve {
namespace {

/// The partition after the first `rows` rows.
absl::StatusOr<Cut> cut_after(const MergeTree& tree, std::size_t rows, const StopToken& stop) {
  StopCheck check(stop);
  const std::size_t m = tree.leaf_count();
  const std::size_t nodes = m + rows;
  // From the top down, the two nodes of a row take over its root.
  std::vector<std::uint32_t> root(nodes);
  check.for_each(0, nodes, [&](std::size_t node) { root[node] = static_cast<std::uint32_t>(node); });
  for (std::size_t row = rows; row-- > 0 && !check.after(1);) {
    root[tree.left[row]] = root[tree.right[row]] = root[m + row];
  }
  const auto points = [&](std::uint32_t node) { return node < m ? tree.leaf_points[node] : tree.points[node - m]; };
  std::vector<std::uint32_t> segments;  // their roots, in the order of their smallest leaves
  std::vector<std::uint32_t> number(nodes, 0);
  check.for_each(0, m, [&](std::size_t leaf) {
    if (number[root[leaf]]++ == 0) segments.push_back(root[leaf]);
  });
  std::vector<std::uint64_t> descending(segments.size());
  check.for_each(0, segments.size(), [&](std::size_t s) { descending[s] = ~std::uint64_t{points(segments[s])}; });
  std::vector<std::uint32_t> order;
  math::sort_order(descending, order, check);
  check.for_each(0, order.size(),
                 [&](std::size_t s) { number[segments[order[s]]] = static_cast<std::uint32_t>(s + 1); });
  Cut cut{std::vector<std::uint32_t>(m), static_cast<std::uint32_t>(segments.size())};
  check.for_each(0, m, [&](std::size_t leaf) { cut.segment_of_leaf[leaf] = number[root[leaf]]; });
  RETURN_IF_ERROR(check.status());
  return cut;
}

}  // namespace

absl::StatusOr<Cut> cut_at_threshold(const MergeTree& tree, double threshold, const StopToken& stop) {
  if (!(threshold >= 0 && threshold <= 1)) {
    return absl::InvalidArgumentError(fmt::format("threshold: {} is not in [0, 1]", threshold));
  }
  std::size_t rows = 0;
  StopCheck check(stop);
  while (rows < tree.row_count() && tree.kind[rows] == MergeKind::kMerged && tree.height[rows] < threshold &&
         !check.after(1)) {
    ++rows;
  }
  return cut_after(tree, rows, stop);
}

absl::StatusOr<Cut> cut_to_regions(const MergeTree& tree, std::uint32_t regions, const StopToken& stop) {
  if (regions == 0) return absl::InvalidArgumentError("regions: 0 is not in [1, 2147483647]");
  const std::size_t m = tree.leaf_count();
  return cut_after(tree, m - std::min<std::size_t>(regions, m), stop);
}

absl::StatusOr<std::vector<std::uint32_t>> label_points(std::span<const std::uint32_t> supervoxels, const Cut& cut) {
  std::vector<std::uint32_t> segment(cut.segment_of_leaf.size() + 1, 0);
  std::ranges::copy(cut.segment_of_leaf, segment.begin() + 1);
  std::vector<std::uint32_t> labels(supervoxels.size());
  for (std::size_t i = 0; i < supervoxels.size(); ++i) {
    if (supervoxels[i] >= segment.size()) {
      return absl::InvalidArgumentError(fmt::format("point {}: supervoxel {} is not a leaf of the tree, which has {}",
                                                    i, supervoxels[i], cut.segment_of_leaf.size()));
    }
    labels[i] = segment[supervoxels[i]];
  }
  return labels;
}

}  // namespace segserve
