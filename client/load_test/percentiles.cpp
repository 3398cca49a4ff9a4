// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/percentiles.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace segserve::bench {

double Samples::mean() const {
  if (values_.empty()) return 0;
  return std::accumulate(values_.begin(), values_.end(), 0.0) / static_cast<double>(values_.size());
}

double Samples::max() const { return values_.empty() ? 0 : *std::ranges::max_element(values_); }

double Samples::percentile(double percent) const {
  if (values_.empty()) return 0;
  // Rounding must not make 99.9 % of 1000 more than 999.
  const double exact = percent / 100 * static_cast<double>(values_.size());
  const auto rank = static_cast<std::size_t>(std::ceil(exact - 1e-9));
  std::vector<double> values = values_;
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, values.size()) - 1);
  std::ranges::nth_element(values, nth);
  return *nth;
}

}  // namespace segserve::bench
