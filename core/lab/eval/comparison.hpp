#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/eval/partition_metrics.hpp"

namespace segserve::eval {

/// Two methods on the same scenes, by one metric.
struct PairedDifference {
  std::size_t metric = 0;  ///< index into kMetrics
  std::size_t scenes = 0;  ///< that have the metric in both
  double mean_a = 0, mean_b = 0;
  double difference = 0;  ///< mean of a - b
  /// Bootstrap: 95 % of 10,000 resamples of the scenes have their mean difference in here (percentiles; the same
  /// numbers on every run).
  double low = 0, high = 0;
  /// Paired t-test, as the paper's: mean difference over its standard error. Infinite if all differences are equal and
  /// not 0.
  double t = 0;
  double p_two_sided = 1;  ///< of a difference as large as this or larger if there is none
  std::optional<double>
      p_better;  ///< one-sided: small if a is better than b; nothing if neither high nor low is better
};

/// One entry for each metric that at least two scenes have in both, scenes paired by file name. INVALID_ARGUMENT if the
/// files are not the same, one is there twice, or there are fewer than two.
absl::StatusOr<std::vector<PairedDifference>> compare(std::span<const SceneScores> a, std::span<const SceneScores> b);

}  // namespace segserve::eval
