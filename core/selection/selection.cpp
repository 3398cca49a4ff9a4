// SPDX-License-Identifier: Apache-2.0
#include "segserve/selection.hpp"

#include <algorithm>
#include <limits>
#include <string_view>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve {
namespace {

using Nodes = std::vector<std::uint32_t>;

/// It is greater than every node.
constexpr std::uint32_t kNoNode = std::numeric_limits<std::uint32_t>::max();

Nodes parents_of(const MergeTree& tree) {
  const std::size_t m = tree.leaf_count();
  Nodes parent(m + tree.row_count(), kNoNode);
  for (std::size_t row = 0; row < tree.row_count(); ++row) {
    parent[tree.left[row]] = parent[tree.right[row]] = static_cast<std::uint32_t>(m + row);
  }
  return parent;
}

absl::Status check_leaves(const MergeTree& tree, std::string_view what, std::span<const std::uint32_t> leaves) {
  for (const std::uint32_t leaf : leaves) {
    if (leaf < tree.leaf_count()) continue;
    return absl::InvalidArgumentError(
        fmt::format("{} leaf {} is not one of the tree, which has {}", what, leaf, tree.leaf_count()));
  }
  return absl::OkStatus();
}

/// Tells for each node whether one of the leaves is it or below it.
std::vector<bool> mark_above(const Nodes& parent, std::span<const std::uint32_t> leaves) {
  std::vector<bool> marked(parent.size(), false);
  for (const std::uint32_t leaf : leaves) {
    for (std::uint32_t node = leaf; node != kNoNode && !marked[node]; node = parent[node]) marked[node] = true;
  }
  return marked;
}

/// The number of positives below each node.
Nodes count_positives(const MergeTree& tree, std::span<const std::uint32_t> positives) {
  const std::size_t m = tree.leaf_count();
  Nodes count(m + tree.row_count(), 0);
  for (const std::uint32_t leaf : positives) count[leaf] = 1;
  for (std::size_t row = 0; row < tree.row_count(); ++row)
    count[m + row] = count[tree.left[row]] + count[tree.right[row]];
  return count;
}

/// Adds the group below a topmost clean node: goes down as long as one child holds all of it.
void add_group(const MergeTree& tree, const Nodes& count, std::uint32_t top, Selection& selection) {
  const auto group = static_cast<std::uint32_t>(selection.smallest.size());
  std::uint32_t node = top;
  while (node >= tree.leaf_count()) {
    const std::size_t row = node - tree.leaf_count();
    const bool is_left = count[tree.left[row]] == count[top], is_right = count[tree.right[row]] == count[top];
    if (!is_left && !is_right) break;
    selection.steps.push_back({group, node});
    node = is_left ? tree.left[row] : tree.right[row];
  }
  selection.smallest.push_back(node);
}

/// The topmost clean node above each clean node, from the root down.
Nodes topmost_clean(const Nodes& parent, const std::vector<bool>& is_negative) {
  Nodes top(parent.size());
  for (std::size_t node = parent.size(); node-- > 0;) {
    const bool is_top = parent[node] == kNoNode || is_negative[parent[node]];
    top[node] = is_top ? static_cast<std::uint32_t>(node) : top[parent[node]];
  }
  return top;
}

bool is_applied(const MergeTree& tree, std::uint32_t node, double threshold) {
  const std::size_t row = node - tree.leaf_count();
  return tree.kind[row] == MergeKind::kMerged && tree.height[row] < threshold;
}

/// The threshold above which a cut makes the node; 1 if none does.
double height_of(const MergeTree& tree, std::uint32_t node) {
  const std::size_t row = node - tree.leaf_count();
  return tree.kind[row] == MergeKind::kMerged ? tree.height[row] : 1;
}

}  // namespace

absl::StatusOr<Selection> select(const MergeTree& tree, std::span<const std::uint32_t> positives,
                                 std::span<const std::uint32_t> negatives) {
  if (positives.empty()) return absl::InvalidArgumentError("nothing is included");
  RETURN_IF_ERROR(check_leaves(tree, "included", positives));
  RETURN_IF_ERROR(check_leaves(tree, "excluded", negatives));
  const Nodes parent = parents_of(tree);
  const std::vector<bool> is_negative = mark_above(parent, negatives);
  const Nodes top_of = topmost_clean(parent, is_negative);

  const Nodes count = count_positives(tree, positives);
  std::vector<bool> is_added(parent.size(), false);
  Selection selection;
  for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf) {
    if (count[leaf] == 0) continue;
    if (is_negative[leaf]) {
      return absl::InvalidArgumentError(fmt::format("supervoxel {} is both included and excluded", leaf + 1));
    }
    const std::uint32_t top = top_of[leaf];
    if (!is_added[top]) add_group(tree, count, top, selection);
    is_added[top] = true;
  }
  std::ranges::sort(selection.steps, {}, &Selection::Step::node);
  return selection;
}

std::vector<std::uint32_t> nodes_of(const Selection& selection, std::size_t candidate) {
  std::vector<std::uint32_t> nodes = selection.smallest;
  for (std::size_t k = 0; k < candidate; ++k) nodes[selection.steps[k].group] = selection.steps[k].node;
  return nodes;
}

std::size_t candidate_at_threshold(const MergeTree& tree, const Selection& selection, double threshold) {
  std::size_t candidate = 0;
  while (candidate < selection.steps.size() && is_applied(tree, selection.steps[candidate].node, threshold)) {
    ++candidate;
  }
  return candidate;
}

std::size_t candidate_for_regions(const MergeTree& tree, const Selection& selection, std::uint32_t regions) {
  const std::size_t m = tree.leaf_count(), nodes = m + (m - std::min<std::size_t>(regions, m));
  const auto is_made = [&](const Selection::Step& step) { return step.node < nodes; };
  return static_cast<std::size_t>(std::ranges::count_if(selection.steps, is_made));
}

ThresholdRange thresholds_of(const MergeTree& tree, const Selection& selection, std::size_t candidate) {
  const auto& steps = selection.steps;
  return {.from = candidate == 0 ? 0 : height_of(tree, steps[candidate - 1].node),
          .to = candidate < steps.size() ? height_of(tree, steps[candidate].node) : 1};
}

std::vector<bool> leaves_below(const MergeTree& tree, std::span<const std::uint32_t> nodes) {
  const std::size_t m = tree.leaf_count();
  std::vector<bool> below(m + tree.row_count(), false);
  for (const std::uint32_t node : nodes) below[node] = true;
  for (std::size_t row = tree.row_count(); row-- > 0;) {
    if (below[m + row]) below[tree.left[row]] = below[tree.right[row]] = true;
  }
  below.resize(m);
  return below;
}

}  // namespace segserve
