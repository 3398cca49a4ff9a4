#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/merge_tree.hpp"

namespace segserve::eval {

/// How many points a ground-truth region and a segment have in common; pairs without any are left out.
struct Overlap {
  std::uint32_t region = 0, segment = 0;  ///< indices into `Contingency::regions` and `::segments`
  std::uint64_t points = 0;
};

struct Part {
  std::uint32_t label = 0;
  std::uint64_t points = 0;
};

/// The contingency table of a segmentation against ground truth, over the points whose ground truth
/// is not 0 (0 = no finite point, dropped before scoring).
struct Contingency {
  std::vector<Part> regions;      ///< of the ground truth, by ascending label
  std::vector<Part> segments;     ///< by ascending label
  std::vector<Overlap> overlaps;  ///< ascending by (region, segment)
  std::uint64_t points = 0;
};

/// One entry a point in both. INVALID_ARGUMENT if the lengths differ or no point has ground truth.
absl::StatusOr<Contingency> tabulate(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> labels);

/// The table of a cut of a merge tree from that of its supervoxels (labels 1..m; 0 stays 0), without another look at
/// the points: what `tabulate` would say of the cut's labels. INVALID_ARGUMENT if a supervoxel is not a leaf of the
/// cut.
absl::StatusOr<Contingency> coarsen(const Contingency& supervoxels, const Cut& cut);

}  // namespace segserve::eval
