// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/point_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"

namespace segserve::codec {
namespace {

/// The quiet NaN, which writers of packed floats use for "no color".
constexpr std::uint32_t kNoColor = 0x7fc00000;

/// Calls function(i, value) with the value of each point, in the column's type.
template <typename Function>
void for_each_value(const Column& column, std::size_t points, StopCheck& check, Function function) {
  visit_type(column.type, [&]<typename T>(T) {
    check.for_each(0, points,
                   [&](std::size_t i) { function(i, load<T>(column.data + i * column.stride, column.order)); });
  });
}

void read_position(const Column& column, StopCheck& check, std::vector<float>& out) {
  for_each_value(column, out.size(), check, [&](std::size_t i, auto value) { out[i] = static_cast<float>(value); });
}

void read_packed(const Column& column, StopCheck& check, std::vector<std::uint32_t>& out) {
  const bool can_be_nan = is_float(column.type);
  check.for_each(0, out.size(), [&](std::size_t i) {
    const auto bits = load<std::uint32_t>(column.data + i * column.stride, column.order);
    out[i] = can_be_nan && bits == kNoColor ? 0 : bits & 0xFFFFFFU;
  });
}

/// The largest value that is finite, and whether all values are multiples of 256.
struct ChannelRange {
  double largest = 0;
  bool multiples_of_256 = true;
};

void extend(ChannelRange& range, const Column& column, std::size_t points, StopCheck& check) {
  for_each_value(column, points, check, [&range](std::size_t /*i*/, auto value) {
    const auto number = static_cast<double>(value);
    if (!std::isfinite(number)) return;
    range.largest = std::max(range.largest, number);
    range.multiples_of_256 = range.multiples_of_256 && std::fmod(number, 256) == 0;
  });
}

/// The factor that makes full intensity 255. Floats up to about 1 have 1 as full
/// intensity. Far above 255 it is 65535, as in LAS files; some writers multiply 8 bits by 256 instead of 257. A little
/// above 255, and beyond 16 bits, a value is taken as a slip among bytes, and clamped.
double channel_scale(const ChannelRange& range, ScalarType type) {
  constexpr double kAboutOne = 1.5, kFarAboveBytes = 1023, kSixteenBits = 65535;
  if (is_float(type) && range.largest <= kAboutOne) return 255;
  if (range.largest <= kFarAboveBytes || range.largest > kSixteenBits) return 1;
  return range.multiples_of_256 ? 1.0 / 256 : 1.0 / 257;
}

/// Rounds to 0 to 255. NaN becomes 0.
std::uint32_t to_channel(double value) {
  if (!(value > 0)) return 0;  // The comparison is false for NaN.
  return value < 255 ? static_cast<std::uint32_t>(std::lround(value)) : 255;
}

/// Sets one of the three bytes of each color, which must be 0 before.
template <typename Convert>
void read_channel(const Column& column, unsigned shift, StopCheck& check, std::vector<std::uint32_t>& out,
                  Convert convert) {
  for_each_value(column, out.size(), check, [&](std::size_t i, auto value) { out[i] |= convert(value) << shift; });
}

/// Whether the values of the channel are bytes. Those of a signed type are the same eight bits.
bool is_byte(const Column& column) { return size_of(column.type) == 1; }

void read_channels(const std::array<Column, 3>& columns, ChannelKind kind, StopCheck& check,
                   std::vector<std::uint32_t>& out) {
  constexpr std::array<unsigned, 3> kShifts{16, 8, 0};
  if (kind == ChannelKind::kIntensity && std::ranges::all_of(columns, is_byte)) {
    for (std::size_t i = 0; i < 3; ++i) {
      read_channel(columns[i], kShifts[i], check, out,
                   [](auto value) { return std::uint32_t{static_cast<std::uint8_t>(value)}; });
    }
    return;
  }
  constexpr double kY = 0.28209479177387814;  // sqrt(1 / (4 pi))
  double scale = 255 * kY, offset = 255 * 0.5;
  if (kind == ChannelKind::kIntensity) {
    ChannelRange range;
    for (const Column& column : columns) extend(range, column, out.size(), check);
    scale = channel_scale(range, columns[0].type);
    offset = 0;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    read_channel(columns[i], kShifts[i], check, out,
                 [scale, offset](auto value) { return to_channel(static_cast<double>(value) * scale + offset); });
  }
}

/// The label, or nullopt if it is not a 32-bit integer. Negative labels and NaN become 0, because other programs mark
/// points without a label by them.
template <typename T>
std::optional<std::uint32_t> to_label(T value) {
  if (!(value > 0)) return 0;
  if constexpr (std::is_floating_point_v<T>) {
    if (value >= T{4294967296} || value != std::floor(value)) return std::nullopt;
  } else {
    if (static_cast<std::uint64_t>(value) > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  }
  return static_cast<std::uint32_t>(value);
}

/// Leaves the cloud without labels, and warns, if one of them is no label.
void read_label(const Column& column, std::size_t points, StopCheck& check, LabeledCloud& out) {
  out.label.resize(points);
  std::string fault;
  for_each_value(column, points, check, [&](std::size_t i, auto value) {
    const auto label = to_label(value);
    if (!label && fault.empty()) {
      fault = fmt::format("the labels are not used: point {} (counted from 0) has {}, which is no 32-bit integer", i,
                          value);
    }
    out.label[i] = label.value_or(0);
  });
  if (fault.empty()) return;
  out.label.clear();
  out.warnings.push_back({WarningReason::kLabelNotUsed, fault});
}

}  // namespace

absl::Status read_columns(const FieldRoles& roles, const std::function<Column(std::size_t field)>& column,
                          std::size_t points, LabeledCloud& out, const StopToken& stop) {
  Cloud& cloud = out.cloud;
  cloud.resize(points, roles.has_color());
  cloud.width = static_cast<std::uint32_t>(points);
  cloud.height = 1;
  StopCheck check(stop);
  read_position(column(roles.position[0]), check, cloud.x);
  read_position(column(roles.position[1]), check, cloud.y);
  read_position(column(roles.position[2]), check, cloud.z);
  if (roles.packed) {
    read_packed(column(*roles.packed), check, cloud.rgb);
  } else if (roles.channels) {
    const auto [red, green, blue] = *roles.channels;
    read_channels({column(red), column(green), column(blue)}, roles.channel_kind, check, cloud.rgb);
  }
  if (roles.label && !check.stopped()) read_label(column(*roles.label), points, check, out);
  return check.status();
}

std::string given_view_rule(const View& view) {
  return view.kind == ViewKind::kCamera ? "CAMERA, as asked for" : "WORLD, as asked for";
}

}  // namespace segserve::codec
