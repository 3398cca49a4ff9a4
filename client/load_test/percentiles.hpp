// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace segserve::bench {

/// Measured values. All of them are kept, so that percentiles are exact.
class Samples {
 public:
  void add(double value) { values_.push_back(value); }
  void add(const Samples& others) { values_.insert(values_.end(), others.values_.begin(), others.values_.end()); }

  std::size_t count() const { return values_.size(); }
  double mean() const;  ///< 0 without values
  double max() const;   ///< 0 without values
  /// The smallest value that at least `percent` (0 to 100) of all values do not exceed: the nearest rank. 0 without
  /// values.
  double percentile(double percent) const;

 private:
  std::vector<double> values_;
};

}  // namespace segserve::bench
