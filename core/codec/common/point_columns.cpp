// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/point_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/packed_color_column.hpp"
#include "core/codec/common/point_positions.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

/// Warns of points that are there, and have no color.
void warn_of_missing_colors(const Column& packed, const Cloud& cloud, StopCheck& check,
                            std::vector<Warning>& warnings) {
  const auto [missing, all] = count_missing_colors(packed, cloud, check);
  if (missing == 0) return;
  warnings.push_back(
      {WarningReason::kColorNotUsed, fmt::format("{} of {} colors are NaN, and become black", missing, all)});
}

/// The smallest and the largest value that is finite, and whether all values are multiples of 256, or whole.
struct ChannelRange {
  double smallest = 0, largest = 0;
  bool multiples_of_256 = true, is_whole = true;
};

void extend(ChannelRange& range, const Column& column, std::size_t points, StopCheck& check) {
  for_each_value(column, points, check, [&range](std::size_t /*i*/, auto value) {
    const auto number = static_cast<double>(value);
    if (!std::isfinite(number)) return;
    range.smallest = std::min(range.smallest, number);
    range.largest = std::max(range.largest, number);
    range.multiples_of_256 = range.multiples_of_256 && std::fmod(number, 256) == 0;
    range.is_whole = range.is_whole && number == std::floor(number);
  });
}

/// The factor that makes full intensity 255. Floats up to about 1 have 1 as full intensity, and so have numbers with
/// decimals whose file claims that they are integers. Far above 255 it is 65535, as in LAS files; some writers multiply
/// 8 bits by 256 instead of 257. A little above 255, and beyond 16 bits, a value is taken as a slip among bytes, and
/// clamped.
double channel_scale(const ChannelRange& range, bool are_floats) {
  constexpr double kAboutOne = 1.5, kFarAboveBytes = 1023, kSixteenBits = 65535;
  if ((are_floats || !range.is_whole) && range.largest <= kAboutOne) return 255;
  if (range.largest <= kFarAboveBytes || range.largest > kSixteenBits) return 1;
  return range.multiples_of_256 ? 1.0 / 256 : 1.0 / 257;
}

/// Whether the values are -1 to 1, with 0 as half intensity. A little below 0 is a slip.
bool are_signed_units(const ChannelRange& range, bool are_floats) {
  constexpr double kLeast = -1.01, kSlip = -0.1, kMost = 1.01;
  return (are_floats || !range.is_whole) && range.smallest >= kLeast && range.smallest < kSlip &&
         range.largest <= kMost;
}

void warn_of_range(const ChannelRange& range, double full, std::size_t values, std::size_t clamped,
                   std::vector<Warning>& warnings) {
  constexpr double kDark = 10;
  if (clamped > values / 100) {
    warnings.push_back({WarningReason::kColorNotUsed,
                        fmt::format("{} of {} color values are beyond 0 to {}, which is taken as full intensity, and "
                                    "are clamped; they reach from {:.4g} to {:.4g}",
                                    clamped, values, full, range.smallest, range.largest)});
  } else if (full == 255 && !range.is_whole && range.largest < kDark) {
    warnings.push_back({WarningReason::kColorNotUsed,
                        fmt::format("the colors reach only {:.4g} of 255, and are nearly black; 0 to 1 would be "
                                    "another range",
                                    range.largest)});
  }
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

/// `claimed` is the type that the channels have by what the file says, if it is the same for all. As text, their
/// numbers have another type.
void read_channels(const std::array<Column, 3>& columns, ChannelKind kind, std::optional<ScalarType> claimed,
                   StopCheck& check, std::vector<std::uint32_t>& out, std::vector<Warning>& warnings) {
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
  ChannelRange range;
  if (kind == ChannelKind::kIntensity) {
    for (const Column& column : columns) extend(range, column, out.size(), check);
    if (claimed == ScalarType::kInt8 && range.is_whole && range.smallest < 0 && range.largest <= 127) {
      for (std::size_t i = 0; i < 3; ++i) {
        read_channel(columns[i], kShifts[i], check, out,
                     [](auto value) { return std::uint32_t{static_cast<std::uint8_t>(static_cast<int>(value))}; });
      }
      return;
    }
    const bool are_floats = claimed && is_float(*claimed);
    const bool are_signed = are_signed_units(range, are_floats);
    scale = are_signed ? 255 * 0.5 : channel_scale(range, are_floats);
    offset = are_signed ? 255 * 0.5 : 0;
  } else if (kind == ChannelKind::kSixteenBits) {
    scale = 1.0 / 257;
    offset = 0;
  }
  constexpr double kSlip = 2;
  std::size_t values = 0, clamped = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    read_channel(columns[i], kShifts[i], check, out, [scale, offset, &values, &clamped](auto value) {
      const double intensity = static_cast<double>(value) * scale + offset;
      values += std::isfinite(intensity) ? 1 : 0;
      clamped += intensity < -kSlip || intensity > 255 + kSlip ? 1 : 0;
      return to_channel(intensity);
    });
  }
  if (kind == ChannelKind::kIntensity) warn_of_range(range, 255 / scale, values, clamped, warnings);
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

/// Returns whether some packed colors are missing.
bool read_color(const PointTable& table, StopCheck& check, LabeledCloud& out) {
  const FieldRoles& roles = table.roles;
  std::vector<std::uint32_t>& rgb = out.cloud.rgb;
  if (roles.packed) {
    const PackedColors found = read_packed_color(table.column(*roles.packed), check, rgb);
    if (found.are_colors) return found.some_are_missing;
    rgb.clear();
    out.warnings.push_back({WarningReason::kColorNotUsed,
                            fmt::format("the cloud has no color: some values of {} are no colors packed into 4 bytes",
                                        quoted(table.fields[*roles.packed].name))});
  } else if (roles.channels) {
    const auto [red, green, blue] = *roles.channels;
    std::optional<ScalarType> claimed = table.fields[red].type;
    if (table.fields[green].type != *claimed || table.fields[blue].type != *claimed) claimed.reset();
    read_channels({table.column(red), table.column(green), table.column(blue)}, roles.channel_kind, claimed, check, rgb,
                  out.warnings);
  } else if (roles.color_vector) {
    std::array<Column, 3> columns;
    columns.fill(table.column(*roles.color_vector));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t place = roles.color_vector_is_reversed ? 2 - k : k;
      columns[k].data += place * size_of(columns[k].type);
    }
    read_channels(columns, roles.channel_kind, table.fields[*roles.color_vector].type, check, rgb, out.warnings);
  }
  return false;
}

/// Copies the values of a field in its type, in little-endian order.
Attribute copy_field(const Field& field, const Column& column, std::size_t points, StopCheck& check) {
  Attribute attribute{std::string(field.name), field.type, field.count, {}};
  const std::size_t size = size_of(field.type), bytes = attribute.bytes_per_point();
  attribute.values.resize(points * bytes);
  visit_type(column.type, [&]<typename Stored>(Stored) {
    visit_type(field.type, [&]<typename Kept>(Kept) {
      check.for_each(0, points, [&](std::size_t i) {
        for (std::size_t k = 0; k < field.count; ++k) {
          const auto stored = load<Stored>(column.data + i * column.stride + k * sizeof(Stored), column.order);
          const auto value = static_cast<Kept>(stored);  // NOLINT(bugprone-signed-char-misuse): keeps its sign
          std::memcpy(attribute.values.data() + i * bytes + k * size, &value, size);
        }
      });
    });
  });
  return attribute;
}

/// Whether the field is a color of which more is known than the three bytes that are made of it.
bool is_harmonic(const FieldRoles& roles, std::size_t field) {
  return roles.channels && roles.channel_kind == ChannelKind::kSphericalHarmonic &&
         std::ranges::count(*roles.channels, field) > 0;
}

void keep_attributes(const PointTable& table, StopCheck& check, LabeledCloud& out) {
  constexpr std::string_view kPadding = "_";
  const std::vector<std::size_t> used = table.roles.fields();
  for (std::size_t i = 0; i < table.fields.size() && !check.stopped(); ++i) {
    const Field& field = table.fields[i];
    const bool is_label = table.roles.label == i;
    const bool is_used = std::ranges::find(used, i) != used.end() && !is_harmonic(table.roles, i);
    if ((is_used && !is_label) || field.name == kPadding || field.count == 0) continue;
    out.attributes.push_back(copy_field(field, table.column(i), table.points(), check));
    if (is_label) out.attributes.back().name = "input_label";
  }
}

ToldUnit told_unit(const PointTable& table) {
  if (table.stated.unit) return {*table.stated.unit, "as the file says"};
  if (table.roles.unit) return {*table.roles.unit, "as the names of their columns say"};
  return table.reference_unit.value_or(ToldUnit{});
}

/// The unit that the file tells. Warns unless it is the meter, which everybody expects.
LengthUnit take_told_unit(const PointTable& table, std::vector<Warning>& warnings) {
  const ToldUnit told = told_unit(table);
  if (told.unit != LengthUnit::kMeter || told.is_doubtful) {
    warnings.push_back({WarningReason::kUnitGuessed,
                        fmt::format("the coordinates are taken as {}, {}", name(told.unit), told.reason)});
  }
  return told.unit;
}

}  // namespace

void leave_out(UnreadableFields unreadable, PointTable& table, std::vector<Warning>& warnings) {
  FieldRoles& roles = table.roles;
  const auto leave_out_with = [&](std::size_t field, WarningReason reason, std::string message) {
    warnings.push_back({reason, std::move(message)});
    table.fields[field].count = 0;
    unreadable.erase(field);
  };
  if (roles.label && unreadable.contains(*roles.label)) {
    leave_out_with(*roles.label, WarningReason::kLabelNotUsed, "the labels are not used: " + unreadable[*roles.label]);
    roles.label.reset();
  }
  for (const std::size_t field : roles.color_fields()) {
    if (!unreadable.contains(field)) continue;
    if (roles.has_color()) {
      leave_out_with(field, WarningReason::kColorNotUsed, "the cloud has no color: " + unreadable[field]);
    }
    roles.drop_color();
    table.fields[field].count = 0;
    unreadable.erase(field);
  }
  for (const auto& [field, words] : unreadable) {
    table.fields[field].count = 0;
    warnings.push_back({WarningReason::kAttributeNotKept,
                        fmt::format("the values of {} are not kept, because some of them are no numbers of its type",
                                    quoted(table.fields[field].name))});
  }
}

absl::Status read_points(const PointTable& given, const ViewEvidence& evidence, const ReadOptions& options,
                         const StopToken& stop, LabeledCloud& out) {
  PointTable table = given;
  if (table.width == 1) std::swap(table.width, table.height);  // A column of points is not organized.
  // Without points there may be no bytes for a column to begin at.
  if (table.points() == 0) table.column = [](std::size_t) { return Column(); };
  const FieldRoles& roles = table.roles;
  out.cloud.resize(table.points(), roles.has_color());
  out.cloud.width = table.width;
  out.cloud.height = table.height;
  StopCheck check(stop);
  const bool has_missing_colors = read_color(table, check, out);
  if (roles.label && !check.stopped()) read_label(table.column(*roles.label), table.points(), check, out);
  if (options.keep_everything) keep_attributes(table, check, out);
  const auto [x, y, z] = roles.position;
  const auto is_of_floats = [&](std::size_t field) { return table.fields[field].type == ScalarType::kFloat32; };
  const bool are_floats = is_of_floats(x) && is_of_floats(y) && is_of_floats(z);
  ReadOptions read = options;
  if (!options.unit) read.unit = take_told_unit(table, out.warnings);
  ViewEvidence all_evidence = evidence;
  if (table.stated.view) all_evidence.stated = table.stated.view;
  RETURN_IF_ERROR(
      read_positions({table.column(x), table.column(y), table.column(z)}, are_floats, all_evidence, read, check, out));
  if (has_missing_colors) warn_of_missing_colors(table.column(*roles.packed), out.cloud, check, out.warnings);
  return check.status();
}

}  // namespace segserve::codec
