// SPDX-License-Identifier: Apache-2.0
#include "core/merging/merge_tree_builder.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

#include "core/base/stop_check.hpp"

namespace segserve {

MergeTreeBuilder::MergeTreeBuilder(std::vector<std::uint32_t> leaf_points) : alive_(leaf_points.size(), true) {
  node_.reserve(leaf_points.size());
  for (std::uint32_t leaf = 0; leaf < leaf_points.size(); ++leaf) node_.push_back({leaf, 1, leaf_points[leaf]});
  tree_.leaf_points = std::move(leaf_points);
}

void MergeTreeBuilder::add_row(std::uint32_t a, std::uint32_t b, double weight, MergeKind kind) {
  const auto row = static_cast<std::uint32_t>(tree_.row_count());
  const Node merged{static_cast<std::uint32_t>(tree_.leaf_count()) + row, node_[a].leaves + node_[b].leaves,
                    node_[a].points + node_[b].points};
  tree_.left.push_back(std::min(node_[a].id, node_[b].id));
  tree_.right.push_back(std::max(node_[a].id, node_[b].id));
  tree_.weight.push_back(weight);
  tree_.height.push_back(row == 0 ? weight : std::max(weight, tree_.height.back()));
  tree_.leaves.push_back(merged.leaves);
  tree_.points.push_back(merged.points);
  tree_.kind.push_back(kind);
  node_[a] = merged;
  alive_[b] = false;
}

void MergeTreeBuilder::join_components(StopCheck& check) {
  using Component = std::pair<std::uint32_t, std::uint32_t>;  // points, region
  std::priority_queue<Component, std::vector<Component>, std::greater<>> smallest;
  for (std::uint32_t r = 0; r < node_.size() && !check.after(1); ++r) {
    if (alive_[r]) smallest.emplace(node_[r].points, r);
  }
  while (smallest.size() > 1 && !check.after(1)) {
    const std::uint32_t first = smallest.top().second;
    smallest.pop();
    const std::uint32_t second = smallest.top().second;
    smallest.pop();
    const auto [a, b] = std::minmax(first, second);
    add_row(a, b, 1.0, MergeKind::kJoined);
    smallest.emplace(node_[a].points, a);
  }
}

}  // namespace segserve
