// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/las_axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace segserve::codec {
namespace {

/// Integers are at most this, so that rounding never leaves 32 bits.
constexpr double kMostInteger = 2147483647.0;

/// Chooses the scale for floats: the power of two with which the largest magnitude just fits.
void choose_power_of_two(LasAxis& axis) {
  constexpr int kBits = 31, kLeastExponent = -60;
  const double largest = std::max(std::abs(axis.low), std::abs(axis.high));
  int exponent = 0;
  std::frexp(largest, &exponent);  // largest < 2^exponent
  axis.scale = std::ldexp(1.0, std::max(exponent - kBits, kLeastExponent));
}

/// Chooses the scale for doubles: the power of ten with which the distance from the middle just fits.
void choose_power_of_ten(LasAxis& axis) {
  constexpr int kFinest = -9, kCoarsest = 300;
  axis.offset = std::round(axis.low / 2 + axis.high / 2);
  const double reach = std::max(axis.high - axis.offset, axis.offset - axis.low);
  int exponent = kFinest;
  const auto scale = [](int power) { return power < 0 ? 1 / std::pow(10.0, -power) : std::pow(10.0, power); };
  while (exponent < kCoarsest && reach / scale(exponent) >= kMostInteger) ++exponent;
  axis.scale = scale(exponent);
}

}  // namespace

absl::StatusOr<LasAxis> choose_axis(const FileContent& content, std::size_t axis,
                                    const std::vector<std::uint32_t>& points) {
  LasAxis chosen;
  if (points.empty()) return chosen;
  chosen.low = std::numeric_limits<double>::infinity();
  chosen.high = -chosen.low;
  for (const std::uint32_t point : points) {
    const double value = coordinate(content, axis, point);
    chosen.low = std::min(chosen.low, value);
    chosen.high = std::max(chosen.high, value);
  }
  if (content.position == nullptr) {
    choose_power_of_two(chosen);
  } else {
    choose_power_of_ten(chosen);
  }
  if (!(std::max(chosen.high - chosen.offset, chosen.offset - chosen.low) / chosen.scale <= kMostInteger)) {
    return absl::InvalidArgumentError(
        fmt::format("LAS cannot hold coordinates from {} to {}", chosen.low, chosen.high));
  }
  return chosen;
}

}  // namespace segserve::codec
