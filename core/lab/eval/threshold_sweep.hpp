// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "absl/status/status.h"
#include "core/lab/eval/contingency.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve::eval {

/// Learns a threshold as the paper does (section 4): among t = 0, 0.01, 0.02 and so on up to 1 it takes the one with
/// the highest mean tp over the scenes, and the smallest of equals. tp is that of one_to_one_scores, because the
/// paper's own formula grows to 1 when everything merges. A scene costs one tabulation of its supervoxels, and every t
/// only a cut of the tree.
class ThresholdSweep {
 public:
  static constexpr std::size_t kThresholds = 101;
  static constexpr double threshold(std::size_t i) { return static_cast<double>(i) / 100; }

  /// Adds a scene: the table of its supervoxels (labels 1 to m) against ground truth, and their tree with m leaves.
  /// INVALID_ARGUMENT if a supervoxel is not a leaf of the tree.
  absl::Status add(const Contingency& supervoxels, const MergeTree& tree);

  std::size_t scenes() const { return scenes_; }
  /// Mean tp at threshold(i); 0 without scenes.
  double tp(std::size_t i) const;
  /// The index of the best threshold.
  std::size_t best() const;

 private:
  std::array<double, kThresholds> sum_{};
  std::size_t scenes_ = 0;
};

}  // namespace segserve::eval
