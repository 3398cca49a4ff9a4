// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/warning.hpp"

namespace segserve::codec {

/// The points of a file that are no measurement because a coordinate is a number that stands for "no data", as grids
/// of heights have them: -9999, -99999, -999999, -32768, -32767, and the lowest float and double. Such a number counts
/// only if it is farther from all other coordinates of its axis than ten times their extent.
class NoDataPoints {
 public:
  /// Looks at the columns of an axis only where its values reach as far as the nearest of these numbers.
  static NoDataPoints find(const std::array<Column, 3>& columns, std::size_t points, StopCheck& check);

  bool has(std::size_t point) const { return !is_no_data_.empty() && is_no_data_[point]; }
  /// Makes them points that are not finite.
  void drop(Cloud& cloud, StopCheck& check) const;
  /// Says how many there are, by the number that stands for it.
  void warn(std::vector<Warning>& warnings) const;

 private:
  std::vector<bool> is_no_data_;  // of each point; empty if there are none
  std::map<double, std::size_t> count_;
};

}  // namespace segserve::codec
