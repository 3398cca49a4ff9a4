// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/merge_tree.hpp"

namespace segserve::eval {

/// The number of points that a ground-truth region and a segment have in common. Pairs without common points are left
/// out.
struct Overlap {
  std::uint32_t region = 0, segment = 0;  ///< Indices into `Contingency::regions` and `Contingency::segments`.
  std::uint64_t points = 0;
};

/// A region or a segment.
struct Part {
  std::uint32_t label = 0;
  std::uint64_t points = 0;
};

/// The contingency table of a segmentation against ground truth. It counts only points whose ground truth is not 0.
struct Contingency {
  std::vector<Part> regions;      ///< Of the ground truth, by ascending label.
  std::vector<Part> segments;     ///< By ascending label.
  std::vector<Overlap> overlaps;  ///< In ascending order of (region, segment).
  std::uint64_t points = 0;
};

/// Both arrays have one entry per point. INVALID_ARGUMENT if the lengths differ or no point has ground truth.
absl::StatusOr<Contingency> tabulate(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> labels);

/// Computes the table of a cut of a merge tree from the table of its supervoxels (labels 1 to m; 0 stays 0), without
/// another pass over the points. The result equals that of `tabulate` for the labels of the cut. INVALID_ARGUMENT if a
/// supervoxel is not a leaf of the tree.
absl::StatusOr<Contingency> coarsen(const Contingency& supervoxels, const Cut& cut);

}  // namespace segserve::eval
