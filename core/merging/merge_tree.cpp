// SPDX-License-Identifier: Apache-2.0
#include "segserve/merge_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "fmt/format.h"

namespace segserve {
namespace {

/// The leaves and points of the nodes that the rows so far have made.
class Nodes {
 public:
  explicit Nodes(const MergeTree& tree) : tree_(tree), used_(tree.leaf_count() + tree.row_count(), false) {}

  std::uint64_t leaves(std::uint32_t node) const {
    return node < tree_.leaf_count() ? 1 : tree_.leaves[node - tree_.leaf_count()];
  }
  std::uint64_t points(std::uint32_t node) const {
    return node < tree_.leaf_count() ? tree_.leaf_points[node] : tree_.points[node - tree_.leaf_count()];
  }
  /// Marks the node as merged. Returns false if it was before.
  bool use(std::uint32_t node) {
    const bool fresh = !used_[node];
    used_[node] = true;
    return fresh;
  }

 private:
  const MergeTree& tree_;
  std::vector<bool> used_;
};

double height_of(const MergeTree& tree, std::size_t row) {
  return std::max(tree.weight[row], row == 0 ? 0.0 : tree.height[row - 1]);
}

absl::Status fault(std::size_t row, std::string_view what) {
  return absl::InvalidArgumentError(fmt::format("merge tree, row {}: {}", row, what));
}

/// Checks the columns that do not follow from others.
absl::Status check_given(const MergeTree& tree, std::size_t row, Nodes& nodes) {
  const std::uint32_t left = tree.left[row], right = tree.right[row];
  if (left >= right || right >= tree.leaf_count() + row) {
    return fault(row, fmt::format("left {} and right {} are not two earlier nodes in order", left, right));
  }
  if (!nodes.use(left) || !nodes.use(right)) return fault(row, "a node is merged twice");
  const double weight = tree.weight[row];
  if (!(weight >= 0 && weight <= 1)) return fault(row, fmt::format("weight {} is not in [0, 1]", weight));
  if (tree.kind[row] == MergeKind::kJoined && weight != 1) {
    return fault(row, fmt::format("it is JOINED, but its weight is {} instead of 1", weight));
  }
  return absl::OkStatus();
}

absl::Status check_row(const MergeTree& tree, std::size_t row, Nodes& nodes) {
  if (absl::Status status = check_given(tree, row, nodes); !status.ok()) return status;
  const std::uint32_t left = tree.left[row], right = tree.right[row];
  if (tree.height[row] != height_of(tree, row)) {
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

absl::Status check_rows(const MergeTree& tree) {
  const std::size_t rows = tree.leaf_count() == 0 ? 0 : tree.leaf_count() - 1;
  if (tree.row_count() == rows) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("merge tree: {} leaves take {} rows, not {}", tree.leaf_count(), rows, tree.row_count()));
}

absl::Status differ_in_length() { return absl::InvalidArgumentError("merge tree: its columns differ in length"); }

}  // namespace

absl::StatusOr<MergeTree> complete(TreeColumns columns) {
  MergeTree tree;
  tree.leaf_points = std::move(columns.leaf_points);
  tree.left = std::move(columns.left);
  tree.right = std::move(columns.right);
  tree.weight = std::move(columns.weight);
  if (absl::Status status = check_rows(tree); !status.ok()) return status;
  const std::size_t rows = tree.row_count();
  if (tree.right.size() != rows || tree.weight.size() != rows) return differ_in_length();
  if (columns.merged_rows > rows) {
    return absl::InvalidArgumentError(fmt::format("merge tree: {} of {} rows are MERGED", columns.merged_rows, rows));
  }
  const std::uint64_t points = std::accumulate(tree.leaf_points.begin(), tree.leaf_points.end(), std::uint64_t{0});
  if (points > std::numeric_limits<std::uint32_t>::max()) {
    return absl::InvalidArgumentError(fmt::format("merge tree: {} points, more than can be counted", points));
  }
  tree.height.resize(rows);
  tree.leaves.resize(rows);
  tree.points.resize(rows);
  tree.kind.assign(rows, MergeKind::kMerged);
  std::fill(tree.kind.begin() + static_cast<std::ptrdiff_t>(columns.merged_rows), tree.kind.end(), MergeKind::kJoined);
  Nodes nodes(tree);
  for (std::size_t row = 0; row < rows; ++row) {
    if (absl::Status status = check_given(tree, row, nodes); !status.ok()) return status;
    tree.height[row] = height_of(tree, row);
    // No node is merged twice, so that these are sums over different leaves.
    tree.leaves[row] = static_cast<std::uint32_t>(nodes.leaves(tree.left[row]) + nodes.leaves(tree.right[row]));
    tree.points[row] = static_cast<std::uint32_t>(nodes.points(tree.left[row]) + nodes.points(tree.right[row]));
  }
  return tree;
}

absl::Status check(const MergeTree& tree) {
  if (absl::Status status = check_rows(tree); !status.ok()) return status;
  const std::size_t rows = tree.row_count();
  if (tree.right.size() != rows || tree.weight.size() != rows || tree.height.size() != rows ||
      tree.leaves.size() != rows || tree.points.size() != rows || tree.kind.size() != rows) {
    return differ_in_length();
  }
  Nodes nodes(tree);
  for (std::size_t row = 0; row < rows; ++row) {
    if (absl::Status status = check_row(tree, row, nodes); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace segserve
