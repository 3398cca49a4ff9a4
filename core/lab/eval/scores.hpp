#pragma once

#include <cstdint>

#include "core/lab/eval/contingency.hpp"

namespace segserve::eval {

/// Shares in [0, 1].
struct Scores {
  double wov = 0;  ///< weighted overlap
  double tp = 0;   ///< true-positive rate
  double fp = 0;   ///< false-positive rate
  double fn = 0;   ///< false-negative rate
  double f = 0;    ///< F-measure; one_to_one only
};

/// Which ground-truth regions count: by OSD's convention labels 1..9 are parts of the table.
enum class Regions : std::uint8_t { kAll, kObjects };
inline constexpr std::uint32_t kFirstObjectLabel = 10;

/// The paper's formulas (section 4): each region takes the segment of highest intersection over
/// union, and segments may be taken more than once. All 0 if no region counts.
Scores paper_scores(const Contingency& table, Regions which);

/// What the authors' program computes: the regions, largest first (ties by label), each take the free
/// segment of largest intersection (ties by label); shares are of all points.
Scores one_to_one_scores(const Contingency& table);

/// Meila (2007), bits: H(regions | segments) + H(segments | regions); 0 if and only if both are the same partition.
double variation_of_information(const Contingency& table);

/// Quality of an over-segmentation.
struct SupervoxelScores {
  /// Share of points that are right if every supervoxel takes the region most of it lies in.
  double achievable_accuracy = 0;
  /// Neubert and Protzel (2012): sum over overlapping pairs of min(|s n g|, |s \ g|) / N.
  double undersegmentation_error = 0;
};
SupervoxelScores supervoxel_scores(const Contingency& table);

}  // namespace segserve::eval
