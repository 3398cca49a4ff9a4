#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Writes the rows of a merge tree. Regions are named by their smallest supervoxel.
class TreeBuilder {
 public:
  /// `leaf_points`: input points of each supervoxel.
  explicit TreeBuilder(std::vector<std::uint32_t> leaf_points);

  /// Region b joins region a (a < b): a MERGED row.
  void merge(std::uint32_t a, std::uint32_t b, double weight) { add_row(a, b, weight, MergeKind::kMerged); }

  /// Joins what has no edges left, always the two of the fewest points (ties: the smaller ids), by
  /// JOINED rows of weight 1, until one tree remains or `check` stops it.
  void join_components(StopCheck& check);

  MergeTree finish() && { return std::move(tree_); }

 private:
  void add_row(std::uint32_t a, std::uint32_t b, double weight, MergeKind kind);

  struct Node {
    std::uint32_t id, leaves, points;
  };
  MergeTree tree_;
  std::vector<Node> node_;  // of each region
  std::vector<bool> alive_;
};

}  // namespace segserve
