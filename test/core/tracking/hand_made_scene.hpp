// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "segserve/segment.hpp"

namespace segserve::test {

/// Segmentations that are put together supervoxel by supervoxel, 2 cm apart, in a WORLD view. Each supervoxel has 50
/// points.
class HandMadeScene {
 public:
  /// Adds a row of supervoxels along x, which are merged from left to right below the threshold of the cut; returns its
  /// node.
  std::uint32_t add_row(const Eigen::Vector3d& first, std::size_t supervoxels, const Eigen::Vector3d& color) {
    std::uint32_t node = add_leaf(first, color);
    for (std::size_t i = 1; i < supervoxels; ++i) {
      node = merge(node, add_leaf(first + Eigen::Vector3d(0.02 * static_cast<double>(i), 0, 0), color), 0.1);
    }
    return node;
  }

  /// Merges two nodes at a weight; the threshold of the cut is 0.5. Returns a node.
  std::uint32_t merge(std::uint32_t a, std::uint32_t b, double weight) {
    rows_.push_back({a, b, weight});
    return kRow + static_cast<std::uint32_t>(rows_.size()) - 1;
  }

  /// Joins whatever is still apart. Rows come by ascending weight.
  Segmentation segmentation() const {
    Segmentation result;
    const auto m = static_cast<std::uint32_t>(features_.size());
    std::vector<Row> rows = rows_;
    std::vector<std::uint32_t> order(rows.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return rows[i].weight; });
    std::vector<std::uint32_t> place(rows.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    const auto node = [&](std::uint32_t id) { return id < kRow ? id : m + place[id - kRow]; };

    TreeColumns columns;
    columns.leaf_points.assign(m, 50);
    std::vector<bool> has_parent(std::size_t{2} * m, false);
    std::uint32_t applied = 0;
    for (const std::uint32_t i : order) {
      add_row(columns, node(rows[i].a), node(rows[i].b), rows[i].weight, has_parent);
      applied += rows[i].weight < 0.5 ? 1 : 0;
    }
    columns.merged_rows = columns.left.size();
    while (columns.left.size() + 1 < m) {
      std::vector<std::uint32_t> roots;
      for (std::uint32_t n = 0; n < m + columns.left.size(); ++n) {
        if (!has_parent[n]) roots.push_back(n);
      }
      add_row(columns, roots[0], roots[1], 1, has_parent);
    }
    result.tree = *complete(std::move(columns));
    result.segments = m - applied;
    result.threshold = 0.5;
    result.resolution.voxel = 0.005;
    result.supervoxel_features = features_;
    result.supervoxel_normals.assign(m, Eigen::Vector3d(0, 0, 1));
    return result;
  }

 private:
  static constexpr std::uint32_t kRow = 1'000'000;
  struct Row {
    std::uint32_t a, b;
    double weight;
  };

  std::uint32_t add_leaf(const Eigen::Vector3d& place, const Eigen::Vector3d& color) {
    features_.push_back({.voxels = 16, .centroid = place, .color = color});
    return static_cast<std::uint32_t>(features_.size()) - 1;
  }
  static void add_row(TreeColumns& columns, std::uint32_t a, std::uint32_t b, double weight,
                      std::vector<bool>& has_parent) {
    columns.left.push_back(std::min(a, b)), columns.right.push_back(std::max(a, b)), columns.weight.push_back(weight);
    has_parent[a] = has_parent[b] = true;
  }

  std::vector<SupervoxelFeatures> features_;
  std::vector<Row> rows_;
};

}  // namespace segserve::test
