// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/eval/partition_metrics.hpp"

namespace segserve::eval {

/// The comparison of two methods, A and B, on the same scenes by one metric.
struct PairedDifference {
  std::size_t metric = 0;  ///< Index into kMetrics.
  std::size_t scenes = 0;  ///< Number of scenes in which the metric is defined for both.
  double mean_a = 0, mean_b = 0;
  double difference = 0;  ///< Mean of a - b.
  /// Bootstrap interval: 95 % of 10,000 resamples of the scenes have their mean difference in here (percentiles). The
  /// numbers are the same on every run.
  double low = 0, high = 0;
  /// Statistic of the paired t-test, as in the paper: the mean difference divided by its standard error. It is infinite
  /// if all differences are equal and not 0.
  double t = 0;
  double p_two_sided = 1;  ///< Probability of such a t, or a larger one in size, if A and B are equally good.
  /// One-sided: small if A is better than B. Unset if neither high nor low values of the metric are better.
  std::optional<double> p_better;
};

/// Pairs the scenes by file name. The result has one entry for each metric that is defined in at least two pairs.
/// INVALID_ARGUMENT if the files differ, if one occurs twice, or if there are fewer than two.
absl::StatusOr<std::vector<PairedDifference>> compare(std::span<const SceneScores> a, std::span<const SceneScores> b);

}  // namespace segserve::eval
