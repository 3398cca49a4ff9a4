// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/packed_color_column.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

namespace segserve::codec {
namespace {

constexpr std::uint32_t kColorBits = 0xFFFFFFU;
/// The quiet NaN, which writers of packed floats use for "no color".
constexpr std::uint32_t kNoColor = 0x7fc00000;

/// Whether floats are packed colors by their values and not by their bits. Looks at a few first, because they nearly
/// always tell that they are not.
bool are_packed_values(const Column& column, std::size_t points, StopCheck& check) {
  constexpr std::size_t kFirst = 64;
  bool are_values = true, is_any = false;
  for (const std::size_t end : {std::min(points, kFirst), points}) {
    for_each_value(column, end, check, [&](std::size_t, auto value) {
      const auto number = static_cast<double>(value);
      if (number == 0 || std::isnan(number)) return;
      is_any = true;
      are_values = are_values && number >= 1 && number < 0x1p24 && number == std::floor(number);
    });
    if (!are_values) return false;
  }
  return is_any;
}

/// The bits of a number that was widened to 8 bytes, or is a color by its value.
template <typename T>
std::optional<std::uint32_t> bits_of_value(T value) {
  constexpr double kSmall = 1e-30, kLarge = 1e37, kLargest = std::numeric_limits<float>::max();
  if constexpr (std::is_floating_point_v<T>) {
    const auto number = static_cast<double>(value);
    const double size = std::abs(number);
    if (std::isnan(number)) return kNoColor;
    if ((size > 0 && size < kSmall) || (size > kLarge && size <= kLargest)) {
      return std::bit_cast<std::uint32_t>(static_cast<float>(number));
    }
    const bool is_integer = number >= -2147483648.0 && number < 4294967296.0 && number == std::floor(number);
    if (!is_integer) return std::nullopt;
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(number));
  } else if constexpr (sizeof(T) < sizeof(std::int64_t)) {
    return std::nullopt;  // No such column is read by its values.
  } else {
    const auto number = static_cast<std::int64_t>(value);
    const bool fits = number >= std::numeric_limits<std::int32_t>::min() &&
                      number <= std::int64_t{std::numeric_limits<std::uint32_t>::max()};
    if (!fits) return std::nullopt;
    return static_cast<std::uint32_t>(number);
  }
}

/// Calls function(i, bits) for each color, with nullopt for a number that is none.
template <typename Function>
void for_each_color(const Column& column, std::size_t points, StopCheck& check, Function function) {
  const bool is_narrow = size_of(column.type) == 4;
  if (!is_narrow || (is_float(column.type) && are_packed_values(column, points, check))) {
    for_each_value(column, points, check, [&](std::size_t i, auto value) { function(i, bits_of_value(value)); });
    return;
  }
  check.for_each(0, points, [&](std::size_t i) {
    function(i, std::optional(load<std::uint32_t>(column.data + i * column.stride, column.order)));
  });
}

}  // namespace

PackedColors read_packed_color(const Column& column, StopCheck& check, std::vector<std::uint32_t>& out) {
  const bool can_be_missing = is_float(column.type);
  PackedColors found;
  for_each_color(column, out.size(), check, [&](std::size_t i, std::optional<std::uint32_t> bits) {
    const bool is_missing = can_be_missing && bits == kNoColor;
    found.are_colors = found.are_colors && bits.has_value();
    found.some_are_missing = found.some_are_missing || is_missing;
    out[i] = is_missing ? 0 : bits.value_or(0) & kColorBits;
  });
  return found;
}

FloatColor float_color(const Column& column, std::size_t points, StopCheck& check) {
  if (column.type != ScalarType::kFloat32) return FloatColor::kNone;
  bool are_packed = true, are_bytes = true;
  std::size_t colors = 0;
  check.for_each(0, points, [&](std::size_t i) {
    const auto bits = load<std::uint32_t>(column.data + i * column.stride, column.order);
    if (bits == 0 || bits == kNoColor) return;
    ++colors;
    are_packed = are_packed && bits <= kColorBits;
    are_bytes = are_bytes && bits > ~kColorBits;
  });
  if (colors == 0) return FloatColor::kNone;
  return are_packed ? FloatColor::kPacked : are_bytes ? FloatColor::kBytes : FloatColor::kNone;
}

MissingColors count_missing_colors(const Column& packed, const Cloud& cloud, StopCheck& check) {
  MissingColors count;
  if (!is_float(packed.type)) return count;
  for_each_color(packed, cloud.size(), check, [&](std::size_t i, std::optional<std::uint32_t> bits) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) return;
    ++count.points;
    count.missing += bits == kNoColor ? 1 : 0;
  });
  return count;
}

}  // namespace segserve::codec
