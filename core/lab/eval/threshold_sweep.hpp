#pragma once

#include <array>
#include <cstddef>

#include "absl/status/status.h"
#include "core/lab/eval/contingency.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve::eval {

/// Learns a threshold as the paper does (section 4): of t = 0, 0.01, .. 1 the one of highest tp, mean over scenes; the
/// smallest of equals. tp is that of one_to_one, as the paper's own formula grows to 1 when everything merges. A scene
/// costs one tabulation of its supervoxels; every t costs only a cut of the tree.
class ThresholdSweep {
 public:
  static constexpr std::size_t kThresholds = 101;
  static constexpr double threshold(std::size_t i) { return static_cast<double>(i) / 100; }

  /// Adds a scene: its supervoxels (labels 1..m) against ground truth, and their tree of m leaves.
  /// INVALID_ARGUMENT if they do not belong together.
  absl::Status add(const Contingency& supervoxels, const MergeTree& tree);

  std::size_t scenes() const { return scenes_; }
  /// Mean tp at threshold(i); 0 without scenes.
  double tp(std::size_t i) const;
  /// The best threshold's i.
  std::size_t best() const;

 private:
  std::array<double, kThresholds> sum_{};
  std::size_t scenes_ = 0;
};

}  // namespace segserve::eval
