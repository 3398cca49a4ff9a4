// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/no_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace segserve::codec {
namespace {

constexpr std::array kNumbers = {-9999.0,
                                 -99999.0,
                                 -999999.0,
                                 -32768.0,
                                 -32767.0,
                                 static_cast<double>(std::numeric_limits<float>::lowest()),
                                 std::numeric_limits<double>::lowest()};
constexpr double kNearest = -9999;
constexpr double kExtents = 10;  // such a number is away from the other coordinates by so many of their extents

bool stands_for_no_data(double value) { return std::ranges::find(kNumbers, value) != kNumbers.end(); }

/// The coordinates of an axis that are measured, and whether there are others.
struct AxisRange {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool has_others = false;

  bool is_apart(double value) const {
    const double away = kExtents * (high - low);
    return value < low - away || value > high + away;
  }
};

AxisRange range_of(const Column& column, std::size_t points, StopCheck& check) {
  double lowest = 0;  // NaN does not change it.
  for_each_value(column, points, check,
                 [&lowest](std::size_t, auto number) { lowest = std::min(lowest, static_cast<double>(number)); });
  AxisRange range;
  if (lowest > kNearest) return range;
  for_each_value(column, points, check, [&](std::size_t, auto number) {
    const auto value = static_cast<double>(number);
    if (!std::isfinite(value)) return;
    if (stands_for_no_data(value)) {
      range.has_others = true;
    } else {
      range.low = std::min(range.low, value), range.high = std::max(range.high, value);
    }
  });
  return range;
}

}  // namespace

NoDataPoints NoDataPoints::find(const std::array<Column, 3>& columns, std::size_t points, StopCheck& check) {
  NoDataPoints found;
  for (const Column& column : columns) {
    const AxisRange range = range_of(column, points, check);
    if (!range.has_others || range.low > range.high) continue;
    for_each_value(column, points, check, [&](std::size_t i, auto number) {
      const auto value = static_cast<double>(number);
      if (!std::isfinite(value) || !stands_for_no_data(value) || !range.is_apart(value)) return;
      found.is_no_data_.resize(points);
      if (!found.is_no_data_[i]) ++found.count_[value];
      found.is_no_data_[i] = true;
    });
  }
  return found;
}

void NoDataPoints::drop(Cloud& cloud, StopCheck& check) const {
  check.for_each(0, is_no_data_.size(), [&](std::size_t i) {
    if (is_no_data_[i]) cloud.x[i] = cloud.y[i] = cloud.z[i] = std::numeric_limits<float>::quiet_NaN();
  });
}

void NoDataPoints::warn(std::vector<Warning>& warnings) const {
  for (const auto& [number, points] : count_) {
    const bool is_one = points == 1;
    warnings.push_back({WarningReason::kPointsNotUsed,
                        fmt::format("{} point{} the coordinate {:.9g}, which stands for no data, and {} not used",
                                    points, is_one ? " has" : "s have", number, is_one ? "is" : "are")});
  }
}

}  // namespace segserve::codec
