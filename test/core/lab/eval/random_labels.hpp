// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/math/random.hpp"

namespace segserve::eval {

using Labels = std::vector<std::uint32_t>;

/// Ground truth and labels of up to 60 points that mostly agree: regions 0 (none), 1, 2 and some objects from 10 on;
/// labels may be 0, too. At least one point has ground truth.
inline std::pair<Labels, Labels> random_labels(Random& random) {
  const std::uint32_t objects = random.below(5);
  Labels truth{1}, labels{1};
  for (std::uint32_t n = 1 + random.below(60); n > 0; --n) {
    const bool object = objects > 0 && random.chance(0.7);
    truth.push_back(object ? 10 + random.below(objects) : random.below(3));
    labels.push_back(random.chance(0.8) ? truth.back() + 1 : random.below(16));
  }
  return {truth, labels};
}

}  // namespace segserve::eval
