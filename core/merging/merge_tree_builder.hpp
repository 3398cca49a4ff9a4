// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/stop_check.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve {

/// Writes the rows of a merge tree. Regions are named by their smallest supervoxel.
class MergeTreeBuilder {
 public:
  /// `leaf_points` are the input points of each supervoxel.
  explicit MergeTreeBuilder(std::vector<std::uint32_t> leaf_points);

  /// Adds the MERGED row in which region b joins region a; a < b.
  void merge(std::uint32_t a, std::uint32_t b, double weight) { add_row(a, b, weight, MergeKind::kMerged); }

  /// Joins regions without edges by JOINED rows of weight 1 until one tree remains or `check` stops it. Each row joins
  /// the two with the fewest points, and of equal ones those with the smaller numbers.
  void join_components(StopCheck& check);

  MergeTree finish() && { return std::move(tree_); }

 private:
  void add_row(std::uint32_t a, std::uint32_t b, double weight, MergeKind kind);

  struct Node {
    std::uint32_t id, leaves, points;
  };
  MergeTree tree_;
  std::vector<Node> node_;   // of each region
  std::vector<bool> alive_;  // whether the region has not joined another one
};

}  // namespace segserve
