// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/threshold_sweep.hpp"

#include <algorithm>

#include "core/base/status_macros.hpp"
#include "core/lab/eval/scores.hpp"

namespace segserve::eval {

absl::Status ThresholdSweep::add(const Contingency& supervoxels, const MergeTree& tree) {
  std::array<double, kThresholds> scene{};
  for (std::size_t i = 0; i < kThresholds; ++i) {
    ASSIGN_OR_RETURN(const Cut cut, cut_at_threshold(tree, threshold(i)));
    ASSIGN_OR_RETURN(const Contingency table, coarsen(supervoxels, cut));
    scene[i] = one_to_one_scores(table).tp;
  }
  std::ranges::transform(sum_, scene, sum_.begin(), std::plus{});
  ++scenes_;
  return absl::OkStatus();
}

double ThresholdSweep::tp(std::size_t i) const { return scenes_ == 0 ? 0 : sum_[i] / static_cast<double>(scenes_); }

std::size_t ThresholdSweep::best() const {
  return static_cast<std::size_t>(std::ranges::max_element(sum_) - sum_.begin());
}

}  // namespace segserve::eval
