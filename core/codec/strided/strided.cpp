// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/strided.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
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

using FieldTriple = std::array<const PointField*, 3>;

/// The fields of a layout that a cloud is made from.
struct LayoutRoles {
  FieldTriple position{};               ///< x, y, z
  const PointField* packed = nullptr;   ///< color as 0xAARRGGBB, or null
  std::optional<FieldTriple> channels;  ///< color as red, green and blue

  bool has_color() const { return packed != nullptr || channels; }
};

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

absl::Status wrong_type(const PointField& field, std::string_view needed) {
  return absl::InvalidArgumentError(fmt::format("field '{}' has datatype {} and count {}; it must be {}", field.name,
                                                static_cast<int>(field.datatype), field.count, needed));
}

/// Whether the field is a single number of one of two types.
bool is_one(const PointField& field, PointDatatype a, PointDatatype b) {
  return field.count <= 1 && (field.datatype == a || field.datatype == b);
}

absl::Status check_types(const LayoutRoles& roles) {
  for (const PointField* field : roles.position) {
    if (!is_one(*field, PointDatatype::kFloat32, PointDatatype::kFloat64)) {
      return wrong_type(*field, "7 (FLOAT32) or 8 (FLOAT64), count 1");
    }
  }
  if (roles.packed != nullptr && !is_one(*roles.packed, PointDatatype::kFloat32, PointDatatype::kUint32)) {
    return wrong_type(*roles.packed, "7 (FLOAT32) or 6 (UINT32), count 1");
  }
  if (!roles.channels) return absl::OkStatus();
  for (const PointField* field : *roles.channels) {
    if (!is_one(*field, PointDatatype::kUint8, PointDatatype::kUint8)) return wrong_type(*field, "2 (UINT8), count 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<LayoutRoles> find_roles(const std::vector<PointField>& fields) {
  std::vector<std::string_view> names(fields.size());
  std::ranges::transform(fields, names.begin(), &PointField::name);
  const auto fields_at = [&fields](const std::array<std::size_t, 3>& indices) {
    return FieldTriple{&fields[indices[0]], &fields[indices[1]], &fields[indices[2]]};
  };
  ASSIGN_OR_RETURN(const auto position, find_triple(names, {"x", "y", "z"}));
  if (!position) return absl::InvalidArgumentError("the fields x, y and z must be there");
  ASSIGN_OR_RETURN(const auto rgb, find_unique(names, "rgb"));
  ASSIGN_OR_RETURN(const auto rgba, find_unique(names, "rgba"));
  ASSIGN_OR_RETURN(const auto channels, find_triple(names, {"r", "g", "b"}));
  LayoutRoles roles;
  roles.position = fields_at(*position);
  if (const auto packed = rgb ? rgb : rgba) {
    roles.packed = &fields[*packed];
  } else if (channels) {
    roles.channels = fields_at(*channels);
  }
  RETURN_IF_ERROR(check_types(roles));
  return roles;
}

absl::Status check_sizes(const StridedLayout& layout, const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_points("", std::uint64_t{layout.width} * layout.height, limits));
  if (layout.bytes() > limits.max_bytes) {
    return over_limit(fmt::format("{} rows of {} bytes exceed the limit of {} bytes", layout.height, layout.row_step,
                                  limits.max_bytes),
                      {"max_bytes", layout.bytes(), limits.max_bytes});
  }
  if (layout.row_step < std::uint64_t{layout.width} * layout.point_step) {
    return absl::InvalidArgumentError(fmt::format("row_step {} is less than {} points of point_step {}",
                                                  layout.row_step, layout.width, layout.point_step));
  }
  if (layout.fields.size() > kMaxFields) {
    return absl::InvalidArgumentError(
        fmt::format("there are {} fields; at most {} are possible", layout.fields.size(), kMaxFields));
  }
  return absl::OkStatus();
}

/// Calls function(i, value) with the T of the field of every point i.
template <typename T, std::endian kOrder, typename Function>
void for_each_value(const StridedLayout& layout, std::string_view data, const PointField& field, StopCheck& check,
                    Function function) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data.data()) + field.offset;
  for (std::uint32_t row = 0; row < layout.height && !check.stopped(); ++row) {
    const std::byte* first = bytes + std::size_t{row} * layout.row_step;
    const std::size_t i = std::size_t{row} * layout.width;
    check.for_each(0, layout.width, [first, i, step = std::size_t{layout.point_step}, function](std::size_t column) {
      function(i + column, load<T>(first + column * step, kOrder));
    });
  }
}

template <std::endian kOrder>
void read_points(const StridedLayout& layout, std::string_view data, const LayoutRoles& roles, StopCheck& check,
                 Cloud& cloud) {
  const std::array<std::vector<float>*, 3> axes{&cloud.x, &cloud.y, &cloud.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto put = [out = axes[axis]->data()](std::size_t i, auto value) { out[i] = static_cast<float>(value); };
    const PointField& field = *roles.position[axis];
    if (field.datatype == PointDatatype::kFloat64) {
      for_each_value<double, kOrder>(layout, data, field, check, put);
    } else {
      for_each_value<float, kOrder>(layout, data, field, check, put);
    }
  }
  std::uint32_t* rgb = cloud.rgb.data();
  if (roles.packed != nullptr) {
    for_each_value<std::uint32_t, kOrder>(layout, data, *roles.packed, check,
                                          [rgb](std::size_t i, std::uint32_t value) { rgb[i] = value & 0xFFFFFFU; });
  } else if (roles.channels) {
    for (unsigned channel = 0; channel < 3; ++channel) {
      for_each_value<std::uint8_t, kOrder>(
          layout, data, *(*roles.channels)[channel], check,
          [rgb, channel](std::size_t i, std::uint32_t value) { rgb[i] |= value << (16 - 8 * channel); });
    }
  }
}

}  // namespace

absl::Status check_layout(const StridedLayout& layout, const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_sizes(layout, limits));
  for (const PointField& field : layout.fields) RETURN_IF_ERROR(check_field(field, layout.point_step));
  return find_roles(layout.fields).status();
}

absl::StatusOr<Cloud> decode_strided(const StridedLayout& layout, std::string_view data, const View& view,
                                     const DecodeLimits& limits, const StopToken& stop) {
  RETURN_IF_ERROR(check_layout(layout, limits));
  if (data.size() != layout.bytes()) {
    return absl::InvalidArgumentError(fmt::format("the data have {} bytes, but {} rows of {} bytes are {}", data.size(),
                                                  layout.height, layout.row_step, layout.bytes()));
  }
  ASSIGN_OR_RETURN(const LayoutRoles roles, find_roles(layout.fields));
  Cloud cloud;
  cloud.width = layout.width;
  cloud.height = layout.height;
  cloud.view = view;
  cloud.resize(std::size_t{layout.width} * layout.height, roles.has_color());
  if (cloud.size() == 0) return cloud;  // There may be 2^32 rows without a point.
  StopCheck check(stop);
  if (layout.is_bigendian) {
    read_points<std::endian::big>(layout, data, roles, check, cloud);
  } else {
    read_points<std::endian::little>(layout, data, roles, check, cloud);
  }
  RETURN_IF_ERROR(check.status());
  return cloud;
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
