// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/point_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/stop_check.hpp"
#include "core/codec/common/point_positions.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

/// The quiet NaN, which writers of packed floats use for "no color".
constexpr std::uint32_t kNoColor = 0x7fc00000;

void read_packed(const Column& column, StopCheck& check, std::vector<std::uint32_t>& out) {
  const bool can_be_nan = is_float(column.type);
  check.for_each(0, out.size(), [&](std::size_t i) {
    const auto bits = load<std::uint32_t>(column.data + i * column.stride, column.order);
    out[i] = can_be_nan && bits == kNoColor ? 0 : bits & 0xFFFFFFU;
  });
}

/// The largest value that is finite, and whether all values are multiples of 256.
struct ChannelRange {
  double smallest = 0, largest = 0;
  bool multiples_of_256 = true;
};

void extend(ChannelRange& range, const Column& column, std::size_t points, StopCheck& check) {
  for_each_value(column, points, check, [&range](std::size_t /*i*/, auto value) {
    const auto number = static_cast<double>(value);
    if (!std::isfinite(number)) return;
    range.smallest = std::min(range.smallest, number);
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

/// `are_signed_bytes`: the file says that the channels are signed bytes. As text, their numbers have a wider type.
void read_channels(const std::array<Column, 3>& columns, ChannelKind kind, bool are_signed_bytes, StopCheck& check,
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
    if (are_signed_bytes && range.smallest < 0 && range.largest <= 127) {
      for (std::size_t i = 0; i < 3; ++i) {
        read_channel(columns[i], kShifts[i], check, out,
                     [](auto value) { return std::uint32_t{static_cast<std::uint8_t>(static_cast<int>(value))}; });
      }
      return;
    }
    scale = channel_scale(range, columns[0].type);
    offset = 0;
  } else if (kind == ChannelKind::kSixteenBits) {
    scale = 1.0 / 257;
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

void read_color(const PointTable& table, StopCheck& check, Cloud& cloud) {
  const FieldRoles& roles = table.roles;
  if (roles.packed) {
    read_packed(table.column(*roles.packed), check, cloud.rgb);
  } else if (roles.channels) {
    const auto [red, green, blue] = *roles.channels;
    const auto is_signed_byte = [&](std::size_t field) { return table.fields[field].type == ScalarType::kInt8; };
    const bool are_signed_bytes = is_signed_byte(red) && is_signed_byte(green) && is_signed_byte(blue);
    read_channels({table.column(red), table.column(green), table.column(blue)}, roles.channel_kind, are_signed_bytes,
                  check, cloud.rgb);
  }
}

/// Copies the values of a field, in little-endian order.
Attribute copy_field(const Field& field, const Column& column, std::size_t points, StopCheck& check) {
  Attribute attribute{std::string(field.name), field.type, field.count, {}};
  const std::size_t size = size_of(field.type), bytes = attribute.bytes_per_point();
  attribute.values.resize(points * bytes);
  check.for_each(0, points, [&](std::size_t i) {
    std::byte* const out = attribute.values.data() + i * bytes;
    std::copy_n(column.data + i * column.stride, bytes, out);
    if (column.order == std::endian::little) return;
    for (std::size_t k = 0; k < field.count; ++k) std::reverse(out + k * size, out + (k + 1) * size);
  });
  return attribute;
}

void keep_attributes(const PointTable& table, StopCheck& check, LabeledCloud& out) {
  constexpr std::string_view kPadding = "_";
  const std::vector<std::size_t> used = table.roles.fields();
  for (std::size_t i = 0; i < table.fields.size() && !check.stopped(); ++i) {
    const Field& field = table.fields[i];
    const bool is_label = table.roles.label == i;
    const bool is_used = std::ranges::find(used, i) != used.end();
    if ((is_used && !is_label) || field.name == kPadding || field.count == 0) continue;
    out.attributes.push_back(copy_field(field, table.column(i), table.points(), check));
    if (is_label) out.attributes.back().name = "input_label";
  }
}

}  // namespace

void leave_out(const std::set<std::size_t>& unreadable, std::vector<Field>& fields, std::vector<Warning>& warnings) {
  for (const std::size_t field : unreadable) {
    fields[field].count = 0;
    warnings.push_back({WarningReason::kAttributeNotKept,
                        fmt::format("the values of {} are not kept, because some of them are no numbers of its type",
                                    quoted(fields[field].name))});
  }
}

absl::Status read_points(const PointTable& given, const ViewEvidence& evidence, const ReadOptions& options,
                         const StopToken& stop, LabeledCloud& out) {
  PointTable table = given;
  // Without points there may be no bytes for a column to begin at.
  if (table.points() == 0) table.column = [](std::size_t) { return Column(); };
  const FieldRoles& roles = table.roles;
  out.cloud.resize(table.points(), roles.has_color());
  out.cloud.width = table.width;
  out.cloud.height = table.height;
  StopCheck check(stop);
  read_color(table, check, out.cloud);
  if (roles.label && !check.stopped()) read_label(table.column(*roles.label), table.points(), check, out);
  if (options.keep_everything) keep_attributes(table, check, out);
  const auto [x, y, z] = roles.position;
  return read_positions({table.column(x), table.column(y), table.column(z)}, evidence, options, check, out);
}

}  // namespace segserve::codec
