// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::bench {

/// A rate that was tried, frames per second, and whether the objectives were met.
struct SearchTry {
  double rate = 0;
  bool met = false;
};

/// The highest rate at which objectives are met.
struct Capacity {
  double low = 0;   ///< the highest rate that met them, in most of its tries; 0: no rate did
  double high = 0;  ///< the lowest rate above it that missed them, in most of its tries; infinity: none did
  std::vector<SearchTry> tries;
};

struct SearchOptions {
  double first = 1;         ///< the rate that is tried first
  double precision = 0.03;  ///< the search ends once `high` is no more than this above `low`, as a share of it
  double highest = 1e6;     ///< no higher rate is tried
  std::size_t most_tries = 60;
};

/// Finds the highest rate by bisection: doubles or halves the first rate until one end of an interval meets the
/// objectives and the other one does not, and halves the interval. Then both ends are tried again, each until two of up
/// to three tries agree, because a single try may be lucky or unlucky; an end that fell by this moves the interval, and
/// the search goes on. `attempt` runs the load at a rate and says whether the objectives were met; its errors end the
/// search.
absl::StatusOr<Capacity> find_capacity(const SearchOptions& options,
                                       const std::function<absl::StatusOr<bool>(double rate)>& attempt);

}  // namespace segserve::bench
