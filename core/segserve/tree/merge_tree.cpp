#include "segserve/tree/merge_tree.hpp"

#include <algorithm>

#include "fmt/format.h"

namespace segserve {
namespace {

/// Leaves and points of nodes 0 .. 2m - 2, as far as the rows have made them.
class Nodes {
 public:
  explicit Nodes(const MergeTree& tree) : tree_(tree), used_(tree.leaf_count() + tree.row_count(), false) {}

  std::uint64_t leaves(std::uint32_t node) const {
    return node < tree_.leaf_count() ? 1 : tree_.leaves[node - tree_.leaf_count()];
  }
  std::uint64_t points(std::uint32_t node) const {
    return node < tree_.leaf_count() ? tree_.leaf_points[node] : tree_.points[node - tree_.leaf_count()];
  }
  /// False if the node was merged before.
  bool use(std::uint32_t node) {
    const bool fresh = !used_[node];
    used_[node] = true;
    return fresh;
  }

 private:
  const MergeTree& tree_;
  std::vector<bool> used_;
};

absl::Status fault(std::size_t row, std::string_view what) {
  return absl::InvalidArgumentError(fmt::format("merge tree, row {}: {}", row, what));
}

absl::Status check_row(const MergeTree& tree, std::size_t row, Nodes& nodes) {
  const std::uint32_t left = tree.left[row], right = tree.right[row];
  if (left >= right || right >= tree.leaf_count() + row) {
    return fault(row, fmt::format("left {} and right {} are not two earlier nodes in order", left, right));
  }
  if (!nodes.use(left) || !nodes.use(right)) return fault(row, "a node is merged twice");
  const double weight = tree.weight[row];
  if (!(weight >= 0 && weight <= 1)) return fault(row, fmt::format("weight {} is not in [0, 1]", weight));
  if (tree.height[row] != std::max(weight, row == 0 ? 0.0 : tree.height[row - 1])) {
    return fault(row, "the height is not the maximum of the weights so far");
  }
  if (tree.leaves[row] != nodes.leaves(left) + nodes.leaves(right) ||
      tree.points[row] != nodes.points(left) + nodes.points(right)) {
    return fault(row, "leaves or points are not the sum of those of its two nodes");
  }
  if (tree.kind[row] != MergeKind::kMerged && tree.kind[row] != MergeKind::kJoined) return fault(row, "unknown kind");
  if (row > 0 && tree.kind[row] == MergeKind::kMerged && tree.kind[row - 1] == MergeKind::kJoined) {
    return fault(row, "a MERGED row comes after a JOINED one");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status check(const MergeTree& tree) {
  const std::size_t rows = tree.row_count();
  if (rows != (tree.leaf_count() == 0 ? 0 : tree.leaf_count() - 1)) {
    return absl::InvalidArgumentError(fmt::format("merge tree: {} leaves take {} rows, not {}", tree.leaf_count(),
                                                  tree.leaf_count() == 0 ? 0 : tree.leaf_count() - 1, rows));
  }
  if (tree.right.size() != rows || tree.weight.size() != rows || tree.height.size() != rows ||
      tree.leaves.size() != rows || tree.points.size() != rows || tree.kind.size() != rows) {
    return absl::InvalidArgumentError("merge tree: its columns differ in length");
  }
  Nodes nodes(tree);
  for (std::size_t row = 0; row < rows; ++row) {
    if (absl::Status status = check_row(tree, row, nodes); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace segserve
