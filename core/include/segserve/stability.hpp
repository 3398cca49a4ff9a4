// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/merge_tree.hpp"
#include "segserve/stop_token.hpp"

// How certain a segment is: over how many thresholds it stays as it is.
namespace segserve {

/// The thresholds t with from < t <= to at which a cut has a certain segment; a leaf also has t = 0. None if both are
/// equal.
struct ThresholdRange {
  double from = 0;  ///< height of the segment's node; 0 for a leaf
  double to = 0;    ///< height of the node that it merges into; 1 if it merges into none, or only by a JOINED row
  /// How stable the segment is, in [0, 1].
  double stability() const { return to - from; }
  bool operator==(const ThresholdRange&) const = default;
};

/// The thresholds of every node of the tree: m leaves and m - 1 rows. A JOINED node is a segment at no threshold; its
/// range is from 1 to 1.
std::vector<ThresholdRange> threshold_ranges(const MergeTree& tree);

/// The node of each segment of a cut to min(regions, m) segments; entry k - 1 is segment k. A cut at a threshold that
/// has so many segments is the same cut. INVALID_ARGUMENT if `regions` is 0. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<std::vector<std::uint32_t>> segment_nodes(const MergeTree& tree, std::uint32_t regions,
                                                         const StopToken& stop = {});

}  // namespace segserve
