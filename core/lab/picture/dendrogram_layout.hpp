// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "segserve/merge_tree.hpp"

namespace segserve::picture {

/// More merges than this cannot be told apart in a picture.
inline constexpr std::uint32_t kMostMergesDrawn = 800;

/// A node of the tree that is drawn.
struct DendrogramBranch {
  double height = 0.0;                   ///< of its merge; 0 for a supervoxel
  double x = 0.0;                        ///< of its stem, as a share of the width of the plot
  double left = 0.0, right = 0.0;        ///< the shares between which its supervoxels are
  std::size_t leaves = 1;                ///< supervoxels below
  std::optional<std::uint32_t> segment;  ///< of all its supervoxels; unset if they belong to several
  bool is_joined = false;                ///< no edge of the graph made it: MergeKind::kJoined
  std::optional<std::size_t> parent;     ///< index of another branch; unset for the root
  std::optional<std::pair<std::size_t, std::size_t>> children;  ///< unset for supervoxels and what is collapsed
};

struct DendrogramLayout {
  std::vector<DendrogramBranch> branches;  ///< parents before their children
  std::size_t collapsed_branches = 0;      ///< branches of more than one supervoxel that have no children
  std::size_t collapsed_leaves = 0;        ///< their supervoxels
  double collapsed_below = 0.0;            ///< the height of the lowest merge that is drawn; 0 if all are
  std::size_t ends = 0;                    ///< branches without children
};

/// Places the last `merges` merges of the tree, but none below `least_height`. Larger branches are at the left, and
/// many supervoxels take more room than few. `segment_of_leaf` has one entry per leaf, of which 0 is "not known".
DendrogramLayout lay_out(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf, std::uint32_t merges,
                         double least_height);

}  // namespace segserve::picture
