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
#include "core/codec/common/color_channels.hpp"
#include "core/codec/common/packed_color_column.hpp"
#include "core/codec/common/point_positions.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

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

/// The columns of the channels that the file has, wherever they are.
std::optional<Channels> channels_of(const PointTable& table) {
  const FieldRoles& roles = table.roles;
  Channels columns;
  if (roles.channels) {
    for (std::size_t k = 0; k < 3; ++k) columns[k] = table.column((*roles.channels)[k]);
    return columns;
  }
  if (!roles.color_vector) return std::nullopt;
  columns.fill(table.column(*roles.color_vector));
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t place = roles.color_vector_is_reversed ? 2 - k : k;
    columns[k].data += place * size_of(columns[k].type);
  }
  return columns;
}

/// The type that all channels have by what the file says.
std::optional<ScalarType> claimed_type(const PointTable& table) {
  if (table.roles.color_vector) return table.fields[*table.roles.color_vector].type;
  const auto [red, green, blue] = *table.roles.channels;
  const ScalarType type = table.fields[red].type;
  const bool are_alike = table.fields[green].type == type && table.fields[blue].type == type;
  return are_alike ? std::optional(type) : std::nullopt;
}

/// How colors that are missing may be marked; packed ones are NaN.
MissingColorSigns read_color(const PointTable& table, StopCheck& check, LabeledCloud& out) {
  const FieldRoles& roles = table.roles;
  std::vector<std::uint32_t>& rgb = out.cloud.rgb;
  if (roles.packed) {
    const PackedColors found = read_packed_color(table.column(*roles.packed), check, rgb);
    if (found.are_colors) return {.is_nan = found.some_are_missing};
    rgb.clear();
    out.warnings.push_back({WarningReason::kColorNotUsed,
                            fmt::format("the cloud has no color: some values of {} are no colors packed into 4 bytes",
                                        quoted(table.fields[*roles.packed].name))});
  } else if (const auto channels = channels_of(table)) {
    return read_channels(*channels, roles.channel_kind, claimed_type(table), check, rgb, out.warnings);
  }
  return {};
}

void warn_of_missing_colors(const PointTable& table, MissingColorSigns signs, StopCheck& check, LabeledCloud& out) {
  if (!table.roles.packed) {
    const auto channels = channels_of(table);
    if (channels) warn_of_missing_channels(*channels, signs, out.cloud, check, out.warnings);
  } else if (signs.is_nan) {
    const auto [missing, all] = count_missing_colors(table.column(*table.roles.packed), out.cloud, check);
    warn_of_missing_colors(missing, all, "NaN", out.warnings);
  }
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
  const MissingColorSigns missing_colors = read_color(table, check, out);
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
  warn_of_missing_colors(table, missing_colors, check, out);
  return check.status();
}

}  // namespace segserve::codec
