#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/stop_token.hpp"

namespace segserve {

enum class MergeKind : std::uint8_t {
  kMerged = 0,  ///< an edge of the region adjacency graph joined the two regions
  kJoined = 1,  ///< no edge was left: components are joined last, so that one full tree exists
};

/// The dendrogram of a scene: m leaves (leaf s - 1 is supervoxel s) and m - 1 rows in merge order.
/// Row r makes node m + r of nodes `left[r]` < `right[r]`: the ids of SciPy's linkage matrix.
struct MergeTree {
  std::vector<std::uint32_t> leaf_points;  ///< m: input points of each supervoxel
  std::vector<std::uint32_t> left, right;  ///< m - 1: node ids
  std::vector<double> weight;              ///< m - 1: dissimilarity of the two regions, [0, 1]; 1 if JOINED
  std::vector<double> height;              ///< m - 1: maximum weight over all rows so far
  std::vector<std::uint32_t> leaves;       ///< m - 1: supervoxels below the new node
  std::vector<std::uint32_t> points;       ///< m - 1: input points below the new node
  std::vector<MergeKind> kind;             ///< m - 1: all MERGED rows come before all JOINED rows

  std::size_t leaf_count() const { return leaf_points.size(); }
  std::size_t row_count() const { return left.size(); }
  bool operator==(const MergeTree&) const = default;
};

/// What of a tree cannot be derived from the rest: what is sent of it.
struct TreeColumns {
  std::vector<std::uint32_t> leaf_points;  ///< these four as above
  std::vector<std::uint32_t> left, right;
  std::vector<double> weight;
  std::size_t merged_rows = 0;  ///< the rows before this one are MERGED, the others JOINED
};

/// The tree of these columns, which may come from the network. INVALID_ARGUMENT unless they describe one: a tree that
/// comes back has passed `check`.
absl::StatusOr<MergeTree> complete(TreeColumns columns);

/// INVALID_ARGUMENT unless the arrays describe a tree as above.
absl::Status check(const MergeTree& tree);

/// One level of the tree. Segments are numbered 1, 2, .. by descending number of input points, ties
/// by smallest supervoxel, so that the numbering depends on nothing but the partition.
struct Cut {
  std::vector<std::uint32_t> segment_of_leaf;  ///< m: 1..segments
  std::uint32_t segments = 0;
};

/// Applies the leading MERGED rows with height < threshold: the paper stops at the first minimum
/// >= t. INVALID_ARGUMENT if the threshold is not in [0, 1].
absl::StatusOr<Cut> cut_at_threshold(const MergeTree& tree, double threshold, const StopToken& stop = {});

/// Applies the first m - d rows, JOINED ones included: min(d, m) segments.
/// INVALID_ARGUMENT if regions is 0.
absl::StatusOr<Cut> cut_to_regions(const MergeTree& tree, std::uint32_t regions, const StopToken& stop = {});

/// Labels of points from their supervoxels (N entries; 0 = not finite, 1..m) in O(N).
/// INVALID_ARGUMENT if a supervoxel is not a leaf of the cut.
absl::StatusOr<std::vector<std::uint32_t>> label_points(std::span<const std::uint32_t> supervoxels, const Cut& cut);

}  // namespace segserve
