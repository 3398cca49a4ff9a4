// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/unit_guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/codec/common/spacing_search.hpp"

namespace segserve::codec {
namespace {

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool is_whole = true;  ///< all values are whole numbers
};

Range range_of(const Column& column, std::size_t points, StopCheck& check) {
  Range range;
  for_each_value(column, points, check, [&range](std::size_t, auto value) {
    const auto v = static_cast<double>(value);
    if (!std::isfinite(v)) return;
    range.low = std::min(range.low, v);
    range.high = std::max(range.high, v);
    range.is_whole = range.is_whole && v == std::floor(v);
  });
  return range;
}

}  // namespace

double guess_unit(const std::array<Column, 3>& columns, std::size_t points, StopCheck& check,
                  std::vector<Warning>& warnings) {
  constexpr double kFarApart = 0.7, kLarge = 100;
  double extent = 0, farthest = 0;
  bool is_whole = true;
  Cloud cloud;
  cloud.resize(points, false);
  const std::array<std::vector<float>*, 3> planes{&cloud.x, &cloud.y, &cloud.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Range range = range_of(columns[axis], points, check);
    extent = std::max(extent, range.high - range.low);
    farthest = std::max({farthest, std::abs(range.low), std::abs(range.high)});
    is_whole = is_whole && range.is_whole;
    for_each_value(columns[axis], points, check, [&, low = range.low](std::size_t i, auto value) {
      (*planes[axis])[i] = static_cast<float>(static_cast<double>(value) - low);
    });
  }
  const auto spacing = point_spacing(cloud, check);
  // Coordinates of the earth are in meters, however far apart the points are.
  constexpr double kEarth = 100'000;
  const bool is_sparse = spacing && *spacing >= kFarApart && farthest < kEarth;
  const bool is_millimeters = is_sparse || (is_whole && extent > kLarge);
  warnings.push_back(
      {WarningReason::kUnitGuessed,
       fmt::format("the coordinates are taken as {}, because {}", is_millimeters ? "millimeters" : "meters",
                   !is_millimeters ? fmt::format("neighboring points are {:.3g} units apart", spacing.value_or(0))
                   : is_sparse     ? fmt::format("neighboring points are {:.3g} units apart", *spacing)
                                   : fmt::format("they are whole numbers that reach over {:.0f} units", extent))});
  return is_millimeters ? 0.001 : 1;
}

}  // namespace segserve::codec
