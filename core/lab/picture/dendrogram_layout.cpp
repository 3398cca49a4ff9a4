// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/dendrogram_layout.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace segserve::picture {
namespace {

constexpr std::uint32_t kSeveral = std::numeric_limits<std::uint32_t>::max();

/// For each node the segment of all its leaves, or kSeveral.
std::vector<std::uint32_t> segments_of_nodes(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf) {
  std::vector<std::uint32_t> segments(segment_of_leaf.begin(), segment_of_leaf.end());
  for (std::uint32_t& segment : segments) segment = segment == 0 ? kSeveral : segment;
  segments.reserve(tree.leaf_count() + tree.row_count());
  for (std::size_t row = 0; row < tree.row_count(); ++row) {
    const std::uint32_t left = segments[tree.left[row]];
    segments.push_back(left == segments[tree.right[row]] ? left : kSeveral);
  }
  return segments;
}

/// The first row that is drawn. Heights never fall from row to row.
std::size_t first_row(const MergeTree& tree, std::uint32_t merges, double least_height) {
  const auto high = std::ranges::lower_bound(tree.height, least_height) - tree.height.begin();
  return std::max(tree.row_count() - std::min<std::size_t>(merges, tree.row_count()), static_cast<std::size_t>(high));
}

class Layouter {
 public:
  Layouter(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf, std::uint32_t merges,
           double least_height)
      : tree_(tree),
        segments_(segments_of_nodes(tree, segment_of_leaf)),
        first_row_(first_row(tree, merges, least_height)) {}

  DendrogramLayout lay_out();

 private:
  std::size_t leaves_of(std::size_t node) const {
    return node < tree_.leaf_count() ? 1 : tree_.leaves[node - tree_.leaf_count()];
  }
  bool has_children(std::size_t node) const { return node >= tree_.leaf_count() + first_row_; }
  /// Adds a node and returns the index of its branch.
  std::size_t add(std::size_t node, std::optional<std::size_t> parent);
  void place();

  const MergeTree& tree_;
  const std::vector<std::uint32_t> segments_;
  const std::size_t first_row_;  // of those that are drawn
  DendrogramLayout layout_;
  std::vector<std::size_t> node_of_branch_;
};

std::size_t Layouter::add(std::size_t node, std::optional<std::size_t> parent) {
  DendrogramBranch branch;
  branch.leaves = leaves_of(node);
  branch.parent = parent;
  if (segments_[node] != kSeveral) branch.segment = segments_[node];
  if (node >= tree_.leaf_count()) {
    branch.height = tree_.height[node - tree_.leaf_count()];
    branch.is_joined = tree_.kind[node - tree_.leaf_count()] == MergeKind::kJoined;
  }
  layout_.branches.push_back(branch);
  node_of_branch_.push_back(node);
  return layout_.branches.size() - 1;
}

/// Gives the ends of the tree their room from the left to the right, and then each merge the middle of its children.
void Layouter::place() {
  // Depth first, the larger child first: the order of the ends from the left.
  std::vector<std::size_t> ends;
  std::vector<std::size_t> stack{0};
  while (!stack.empty()) {
    const std::size_t branch = stack.back();
    stack.pop_back();
    if (const auto& children = layout_.branches[branch].children) {
      stack.push_back(children->second);
      stack.push_back(children->first);
    } else {
      ends.push_back(branch);
    }
  }
  // Half of the room is shared out equally, so that small branches can be seen.
  const auto weight = [&](std::size_t branch) {
    return std::sqrt(static_cast<double>(layout_.branches[branch].leaves));
  };
  double all = 0.0;
  for (const std::size_t end : ends) all += weight(end);
  double at = 0.0;
  for (const std::size_t end : ends) {
    DendrogramBranch& branch = layout_.branches[end];
    branch.left = at;
    at += 0.5 / static_cast<double>(ends.size()) + 0.5 * weight(end) / all;
    branch.right = at;
    branch.x = 0.5 * (branch.left + branch.right);
  }
  for (std::size_t i = layout_.branches.size(); i-- > 0;) {
    DendrogramBranch& branch = layout_.branches[i];
    if (!branch.children) continue;
    const DendrogramBranch& left = layout_.branches[branch.children->first];
    const DendrogramBranch& right = layout_.branches[branch.children->second];
    branch.left = left.left;
    branch.right = right.right;
    branch.x = 0.5 * (left.x + right.x);
  }
}

DendrogramLayout Layouter::lay_out() {
  if (tree_.leaf_count() == 0) return layout_;
  add(tree_.leaf_count() + tree_.row_count() - 1, std::nullopt);
  for (std::size_t i = 0; i < layout_.branches.size(); ++i) {
    const std::size_t node = node_of_branch_[i];
    if (!has_children(node)) {
      ++layout_.ends;
      if (layout_.branches[i].leaves == 1) continue;
      ++layout_.collapsed_branches;
      layout_.collapsed_leaves += layout_.branches[i].leaves;
      continue;
    }
    const std::size_t row = node - tree_.leaf_count();
    std::size_t first = tree_.left[row];
    std::size_t second = tree_.right[row];
    if (leaves_of(first) < leaves_of(second)) std::swap(first, second);
    const std::size_t left = add(first, i);
    const std::size_t right = add(second, i);
    layout_.branches[i].children = {left, right};
  }
  if (first_row_ > 0 && first_row_ < tree_.row_count()) layout_.collapsed_below = tree_.height[first_row_];
  place();
  return layout_;
}

}  // namespace

DendrogramLayout lay_out(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf, std::uint32_t merges,
                         double least_height) {
  return Layouter(tree, segment_of_leaf, merges, least_height).lay_out();
}

}  // namespace segserve::picture
