// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Why two regions became one.
enum class MergeKind : std::uint8_t {
  kMerged = 0,  ///< They had an edge in the region adjacency graph.
  kJoined = 1,  ///< No edge was left. Components are joined last, so that there is one tree.
};

/// The merge tree (dendrogram) of a scene: m leaves, of which leaf s - 1 is supervoxel s, and m - 1 rows in the order
/// of the merges. Row r makes node m + r of the nodes `left[r]` < `right[r]`. Nodes are numbered as in the linkage
/// matrix of SciPy.
struct MergeTree {
  std::vector<std::uint32_t> leaf_points;  ///< m: input points of each supervoxel
  std::vector<std::uint32_t> left, right;  ///< m - 1: node ids
  std::vector<double> weight;              ///< m - 1: dissimilarity of the two regions, in [0, 1]; 1 if JOINED
  std::vector<double> height;              ///< m - 1: maximum weight of the rows 0 to r
  std::vector<std::uint32_t> leaves;       ///< m - 1: supervoxels below the new node
  std::vector<std::uint32_t> points;       ///< m - 1: input points below the new node
  std::vector<MergeKind> kind;             ///< m - 1: all MERGED rows come before all JOINED rows

  std::size_t leaf_count() const { return leaf_points.size(); }
  std::size_t row_count() const { return left.size(); }
  bool operator==(const MergeTree&) const = default;
};

/// The columns of a tree that cannot be derived from others. Only they are sent.
struct TreeColumns {
  std::vector<std::uint32_t> leaf_points;  ///< the first four columns are as in MergeTree
  std::vector<std::uint32_t> left, right;
  std::vector<double> weight;
  std::size_t merged_rows = 0;  ///< the number of MERGED rows, which come before the JOINED ones
};

/// Derives the other columns of a tree. The columns may come from the network: INVALID_ARGUMENT unless they describe a
/// tree. A tree that is returned would pass `check`.
absl::StatusOr<MergeTree> complete(TreeColumns columns);

/// INVALID_ARGUMENT, naming the first wrong row, unless the columns describe a tree (MergeTree).
absl::Status check(const MergeTree& tree);

/// A partition of the supervoxels into segments: one level of the tree. Segments are numbered from 1 by descending
/// number of input points, and of equal ones by their smallest supervoxel. So the numbers depend on the partition
/// alone.
struct Cut {
  std::vector<std::uint32_t> segment_of_leaf;  ///< m: in [1, segments]
  std::uint32_t segments = 0;
};

/// Applies the leading MERGED rows with height < threshold, because the paper stops at the first minimum weight >= t.
/// INVALID_ARGUMENT if the threshold is not in [0, 1]. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<Cut> cut_at_threshold(const MergeTree& tree, double threshold, const StopToken& stop = {});

/// Applies the first m - regions rows, JOINED ones included, which leaves min(regions, m) segments.
/// INVALID_ARGUMENT if `regions` is 0. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<Cut> cut_to_regions(const MergeTree& tree, std::uint32_t regions, const StopToken& stop = {});

/// Labels points by their supervoxels: N entries in [0, m], of which 0 stays 0. O(N).
/// INVALID_ARGUMENT if a supervoxel is not a leaf of the cut.
absl::StatusOr<std::vector<std::uint32_t>> label_points(std::span<const std::uint32_t> supervoxels, const Cut& cut);

}  // namespace segserve
