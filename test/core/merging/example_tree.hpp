// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "segserve/merge_tree.hpp"

namespace segserve {

/// A tree of five leaves. The weight falls after the second row, so that it differs from the height. The last row is
/// JOINED.
inline MergeTree example_tree() {
  MergeTree tree;
  tree.leaf_points = {10, 20, 30, 30, 5};
  tree.left = {0, 2, 5, 4};
  tree.right = {1, 3, 6, 7};
  tree.weight = {0.1, 0.4, 0.2, 1};
  tree.height = {0.1, 0.4, 0.4, 1};
  tree.leaves = {2, 2, 4, 5};
  tree.points = {30, 60, 90, 95};
  tree.kind = {MergeKind::kMerged, MergeKind::kMerged, MergeKind::kMerged, MergeKind::kJoined};
  return tree;
}

}  // namespace segserve
