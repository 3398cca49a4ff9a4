// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/lab/eval/contingency.hpp"

namespace segserve::eval {

/// Scores of a segmentation: shares in [0, 1].
struct Scores {
  double wov = 0;  ///< Weighted overlap.
  double tp = 0;   ///< True-positive rate.
  double fp = 0;   ///< False-positive rate.
  double fn = 0;   ///< False-negative rate.
  double f = 0;    ///< F-measure; one_to_one_scores only.
};

/// The ground-truth regions that are scored. By OSD's convention the labels 1 to 9 are parts of the table.
enum class Regions : std::uint8_t { kAll, kObjects };
inline constexpr std::uint32_t kFirstObjectLabel = 10;

/// The paper's formulas (section 4): each region takes the segment of highest intersection over union, and a segment
/// may be taken more than once. All scores are 0 if no region is scored.
Scores paper_scores(const Contingency& table, Regions which);

/// The scores that the authors' program computes: the regions, largest first (ties by label), each take the free
/// segment of largest intersection (ties by label). Shares are relative to all points.
Scores one_to_one_scores(const Contingency& table);

/// H(regions | segments) + H(segments | regions) in bits (Meila 2007). It is 0 if and only if both partitions are the
/// same.
double variation_of_information(const Contingency& table);

/// Quality of an over-segmentation.
struct SupervoxelScores {
  /// Share of the points that are right if every supervoxel takes the region in which most of it lies.
  double achievable_accuracy = 0;
  /// Neubert and Protzel (2012): sum over overlapping pairs of min(|s n g|, |s \ g|) / N.
  double undersegmentation_error = 0;
};
SupervoxelScores supervoxel_scores(const Contingency& table);

}  // namespace segserve::eval
