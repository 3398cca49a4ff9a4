// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/strided.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kMaxFields = 64;

/// Bytes of a number; 0 for a number of a datatype that does not exist.
std::size_t size_of(PointDatatype type) {
  constexpr std::array<std::size_t, 9> kSizes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  const auto index = static_cast<std::size_t>(type);
  return index < kSizes.size() ? kSizes[index] : 0;
}

absl::Status check_field(const PointField& field, std::uint32_t point_step) {
  const std::uint64_t size = size_of(field.datatype);
  if (size == 0) {
    return absl::InvalidArgumentError(fmt::format("field '{}' has datatype {}; it must be 1 (INT8) to 8 (FLOAT64)",
                                                  field.name, static_cast<int>(field.datatype)));
  }
  const std::uint64_t count = field.count == 0 ? 1 : field.count;
  const std::uint64_t end = field.offset + size * count;  // less than 2^36
  if (end <= point_step) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("field '{}' at offset {} ends at byte {}, beyond point_step {}",
                                                field.name, field.offset, end, point_step));
}

ScalarType scalar_type(PointDatatype type) {
  constexpr std::array<ScalarType, 9> kTypes{ScalarType::kInt8,   ScalarType::kInt8,    ScalarType::kUint8,
                                             ScalarType::kInt16,  ScalarType::kUint16,  ScalarType::kInt32,
                                             ScalarType::kUint32, ScalarType::kFloat32, ScalarType::kFloat64};
  return kTypes[static_cast<std::size_t>(type)];
}

/// The fields, which check_field has accepted, as find_field_roles has them.
std::vector<Field> table_fields(const StridedLayout& layout) {
  std::vector<Field> fields;
  for (const PointField& field : layout.fields) {
    fields.push_back({field.name, scalar_type(field.datatype), std::max<std::size_t>(field.count, 1)});
  }
  return fields;
}

/// Bytes of a row, for messages.
std::uint64_t row_bytes(const StridedLayout& layout) { return layout.height == 1 ? layout.bytes() : layout.row_step; }

absl::Status check_sizes(const StridedLayout& layout, const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_points("", std::uint64_t{layout.width} * layout.height, limits));
  if (layout.bytes() > limits.max_bytes) {
    return over_limit(fmt::format("{} rows of {} bytes exceed the limit of {} bytes", layout.height, row_bytes(layout),
                                  limits.max_bytes),
                      {"max_bytes", layout.bytes(), limits.max_bytes});
  }
  if (layout.height != 1 && layout.row_step < std::uint64_t{layout.width} * layout.point_step) {
    return absl::InvalidArgumentError(fmt::format("row_step {} is less than {} points of point_step {}",
                                                  layout.row_step, layout.width, layout.point_step));
  }
  if (layout.fields.size() > kMaxFields) {
    return absl::InvalidArgumentError(
        fmt::format("there are {} fields; at most {} are possible", layout.fields.size(), kMaxFields));
  }
  return absl::OkStatus();
}

/// The rows without the gaps between them.
std::string without_gaps(const StridedLayout& layout, std::string_view data) {
  const std::size_t bytes = std::size_t{layout.width} * layout.point_step;
  std::string rows;
  rows.reserve(layout.height * bytes);
  for (std::uint32_t row = 0; row < layout.height; ++row)
    rows += data.substr(std::size_t{row} * layout.row_step, bytes);
  return rows;
}

}  // namespace

absl::Status check_layout(const StridedLayout& layout, const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_sizes(layout, limits));
  for (const PointField& field : layout.fields) RETURN_IF_ERROR(check_field(field, layout.point_step));
  std::vector<Warning> ignored;
  return find_field_roles(table_fields(layout), ignored).status();
}

absl::StatusOr<LabeledCloud> decode_strided(const StridedLayout& layout, std::string_view data,
                                            const ReadOptions& options, const DecodeLimits& limits,
                                            const StopToken& stop) {
  RETURN_IF_ERROR(check_layout(layout, limits));
  if (data.size() != layout.bytes()) {
    return absl::InvalidArgumentError(fmt::format("the data have {} bytes, but {} rows of {} bytes are {}", data.size(),
                                                  layout.height, row_bytes(layout), layout.bytes()));
  }
  LabeledCloud out;
  PointTable table{table_fields(layout), {}, layout.width, layout.height, nullptr};
  ASSIGN_OR_RETURN(table.roles, find_field_roles(table.fields, out.warnings));
  std::string rows;
  // There may be 2^32 rows without a point.
  const bool has_gaps =
      layout.height > 1 && layout.row_step != std::uint64_t{layout.width} * layout.point_step && table.points() > 0;
  if (has_gaps) {
    rows = without_gaps(layout, data);
    data = rows;
  }
  const std::endian order = layout.is_bigendian ? std::endian::big : std::endian::little;
  table.column = [&](std::size_t field) {
    const auto* const bytes = reinterpret_cast<const std::byte*>(data.data());
    return Column{bytes + layout.fields[field].offset, layout.point_step, table.fields[field].type, order};
  };
  RETURN_IF_ERROR(read_points(table, {}, options, stop, out));
  return out;
}

StridedCloud encode_strided(const CloudView& cloud) {
  StridedCloud strided;
  StridedLayout& layout = strided.layout;
  layout.width = cloud.width;
  layout.height = cloud.height;
  for (const char* name : {"x", "y", "z", "rgb"}) {
    if (layout.fields.size() == 3 && !cloud.has_color()) break;
    layout.fields.push_back({name, layout.point_step, PointDatatype::kFloat32, 1});
    layout.point_step += 4;
  }
  layout.row_step = layout.width * layout.point_step;
  strided.data.resize(cloud.size() * layout.point_step);
  char* at = strided.data.data();
  for (std::size_t i = 0; i < cloud.size(); ++i, at += layout.point_step) {
    const std::array<float, 3> position{cloud.x[i], cloud.y[i], cloud.z[i]};
    std::memcpy(at, position.data(), sizeof(position));
    if (!cloud.has_color()) continue;
    const std::uint32_t rgb = cloud.rgb[i] & 0xFFFFFFU;
    std::memcpy(at + sizeof(position), &rgb, sizeof(rgb));
  }
  return strided;
}

}  // namespace segserve::codec
