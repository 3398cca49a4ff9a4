// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/merge_tree.hpp"
#include "segserve/stability.hpp"

// Segments that are chosen by clicks. The merge tree answers in microseconds, without the points.
namespace segserve {

/// Sets of nodes of a merge tree that hold some supervoxels and exclude others.
///
/// A node is clean if no negative leaf is below it. The positives below the same topmost clean node are a group. One
/// node for each group, `groups` in all, is the least number of clean nodes that hold all positives. There is a choice
/// of such nodes: any clean node that holds its group will do. The candidates are the sets that a cut makes of them
/// which moves from fine to coarse:
///
///  - candidate 0 is the smallest: the lowest node that holds each group (`smallest`),
///  - candidate k + 1 is candidate k after steps[k], which puts a node in place of its child,
///  - the last one is the largest: the topmost clean node of each group.
///
/// Groups are in the order of their smallest positive leaf, and steps in that of the tree's rows.
struct Selection {
  struct Step {
    std::uint32_t group = 0;  ///< index into `smallest`
    std::uint32_t node = 0;   ///< the node that holds the group from now on
    bool operator==(const Step&) const = default;
  };
  std::vector<std::uint32_t> smallest;  ///< a node for each group
  std::vector<Step> steps;              ///< at most m - 1, ascending by node

  std::size_t candidates() const { return steps.size() + 1; }
  bool operator==(const Selection&) const = default;
};

/// Selects by leaves: supervoxel s is leaf s - 1. They may be given repeatedly and in any order. O(m) plus the sort of
/// the steps. INVALID_ARGUMENT if there is no positive leaf, a leaf is not one of the tree, or one is positive and
/// negative.
absl::StatusOr<Selection> select(const MergeTree& tree, std::span<const std::uint32_t> positives,
                                 std::span<const std::uint32_t> negatives);

/// The nodes of a candidate, one for each group. `candidate` is less than candidates().
std::vector<std::uint32_t> nodes_of(const Selection& selection, std::size_t candidate);

/// The candidate that a cut at this threshold, or to so many regions, makes. Without negatives, and with one positive,
/// it is the segment of that cut.
std::size_t candidate_at_threshold(const MergeTree& tree, const Selection& selection, double threshold);
std::size_t candidate_for_regions(const MergeTree& tree, const Selection& selection, std::uint32_t regions);

/// The thresholds over which a candidate is the one that the cut makes; for a single node its threshold range, but
/// that the smallest candidate begins at 0.
ThresholdRange thresholds_of(const MergeTree& tree, const Selection& selection, std::size_t candidate);

/// Tells for each of the m leaves whether it is below one of the nodes. Nodes must be those of the tree.
std::vector<bool> leaves_below(const MergeTree& tree, std::span<const std::uint32_t> nodes);

}  // namespace segserve
