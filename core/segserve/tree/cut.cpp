#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "fmt/format.h"
#include "segserve/tree/merge_tree.hpp"

namespace segserve {
namespace {

/// The partition after the first `rows` rows, numbered by descending points, ties by smallest leaf.
Cut cut_after(const MergeTree& tree, std::size_t rows) {
  const std::size_t m = tree.leaf_count();
  const std::size_t nodes = m + rows;
  // From the top down, every node inherits the root above it.
  std::vector<std::uint32_t> root(nodes);
  std::iota(root.begin(), root.end(), 0U);
  for (std::size_t row = rows; row-- > 0;) {
    root[tree.left[row]] = root[tree.right[row]] = root[m + row];
  }
  const auto points = [&](std::uint32_t node) { return node < m ? tree.leaf_points[node] : tree.points[node - m]; };
  std::vector<std::uint32_t> segments;  // roots, in the order of their smallest leaf
  std::vector<std::uint32_t> number(nodes, 0);
  for (std::size_t leaf = 0; leaf < m; ++leaf) {
    if (number[root[leaf]]++ == 0) segments.push_back(root[leaf]);
  }
  std::ranges::stable_sort(segments, std::ranges::greater{}, points);
  for (std::size_t s = 0; s < segments.size(); ++s) number[segments[s]] = static_cast<std::uint32_t>(s + 1);
  Cut cut{std::vector<std::uint32_t>(m), static_cast<std::uint32_t>(segments.size())};
  for (std::size_t leaf = 0; leaf < m; ++leaf) cut.segment_of_leaf[leaf] = number[root[leaf]];
  return cut;
}

}  // namespace

absl::StatusOr<Cut> cut_at_threshold(const MergeTree& tree, double threshold) {
  if (!(threshold >= 0 && threshold <= 1)) {
    return absl::InvalidArgumentError(fmt::format("threshold: {} is not in [0, 1]", threshold));
  }
  std::size_t rows = 0;
  while (rows < tree.row_count() && tree.kind[rows] == MergeKind::kMerged && tree.height[rows] < threshold) ++rows;
  return cut_after(tree, rows);
}

absl::StatusOr<Cut> cut_to_regions(const MergeTree& tree, std::uint32_t regions) {
  if (regions == 0) return absl::InvalidArgumentError("regions: 0 is not in [1, 2147483647]");
  const std::size_t m = tree.leaf_count();
  return cut_after(tree, m - std::min<std::size_t>(regions, m));
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
