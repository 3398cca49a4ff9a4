// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/lab/eval/contingency.hpp"

namespace segserve::eval {

/// The overlap measures of unseen object instance segmentation (Xie et al. 2020 and 2021, "UOIS"). The objects and the
/// detections (instance_scores.hpp, Regions::kObjects) are assigned to each other so that the sum of the pairs' F is
/// largest, where F is the harmonic mean of |g n s| / |s| and |g n s| / |g|.
struct OverlapScores {
  /// Sum of |g n s| over the pairs / points of all detections. Unset if there is no detection.
  std::optional<double> precision;
  double recall = 0;       ///< Sum of |g n s| over the pairs / points of all objects.
  double f = 0;            ///< Harmonic mean of both; 0 without a detection.
  double objects_f75 = 0;  ///< Share of the objects whose pair has an F of at least 0.75.
};

/// Unset if there is no object.
std::optional<OverlapScores> overlap_scores(const Contingency& table);

}  // namespace segserve::eval
