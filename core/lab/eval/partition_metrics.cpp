// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/partition_metrics.hpp"

namespace segserve::eval {

MetricValues mean(std::span<const SceneScores> scenes) {
  MetricValues means;
  for (std::size_t m = 0; m < means.size(); ++m) {
    double sum = 0;
    double count = 0;
    for (const SceneScores& scene : scenes) {
      const std::optional<double>& value = scene.values[m];
      if (!value) continue;
      sum += *value;
      ++count;
    }
    if (count > 0) means[m] = sum / count;
  }
  return means;
}

}  // namespace segserve::eval
