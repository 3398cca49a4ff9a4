// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/node_assignment.hpp"

#include <gmock/gmock.h>

#include <random>

#include "test/core/selection/random_tree.hpp"

namespace segserve::tracking {
namespace {

Segmentation segmentation_of(MergeTree tree) {
  Segmentation result;
  result.supervoxel_features.assign(tree.leaf_count(), {.voxels = 1});
  result.supervoxel_normals.assign(tree.leaf_count(), Eigen::Vector3d(0, 0, 1));
  result.segments = static_cast<std::uint32_t>(tree.leaf_count());
  result.resolution.voxel = 0.01;
  result.tree = std::move(tree);
  return result;
}

/// The greatest sum of scores of nodes that do not nest, by trying everything.
double best_sum(const SceneTree& scene, const std::vector<std::vector<NodeCandidate>>& candidates,
                std::vector<std::uint32_t>& chosen) {
  if (chosen.size() == candidates.size()) return 0;
  const std::vector<NodeCandidate>& own = candidates[chosen.size()];
  chosen.push_back(kNoNode);
  double best = best_sum(scene, candidates, chosen);
  for (const NodeCandidate& candidate : own) {
    chosen.pop_back();
    const bool is_free =
        std::ranges::none_of(chosen, [&](std::uint32_t n) { return n != kNoNode && scene.nest(n, candidate.node); });
    chosen.push_back(candidate.node);
    if (is_free) best = std::max(best, candidate.score + best_sum(scene, candidates, chosen));
  }
  chosen.pop_back();
  return best;
}

TEST(NodeAssignment, IsTheBestOfAllThatDoNotNest) {
  std::mt19937 random(1);
  for (int turn = 0; turn < 200; ++turn) {
    const Segmentation segmentation = segmentation_of(random_tree(12, random));
    const SceneTree scene = *SceneTree::make(segmentation, View::world(), {});
    std::vector<std::vector<NodeCandidate>> candidates(5);
    for (auto& list : candidates) {
      for (int k = 0; k < 4; ++k) {
        list.push_back({static_cast<std::uint32_t>(random() % scene.node_count()), 0.3 + 0.1 * (random() % 8)});
      }
      std::ranges::stable_sort(list, std::ranges::greater{}, &NodeCandidate::score);
    }
    const std::vector<std::uint32_t> nodes = assign_nodes(scene, candidates);
    double sum = 0;
    for (std::size_t t = 0; t < nodes.size(); ++t) {
      if (nodes[t] == kNoNode) continue;
      sum += std::ranges::find(candidates[t], nodes[t], &NodeCandidate::node)->score;
      for (std::size_t u = 0; u < t; ++u) EXPECT_TRUE(nodes[u] == kNoNode || !scene.nest(nodes[t], nodes[u]));
    }
    std::vector<std::uint32_t> chosen;
    EXPECT_NEAR(sum, best_sum(scene, candidates, chosen), 1e-12);
  }
}

}  // namespace
}  // namespace segserve::tracking
