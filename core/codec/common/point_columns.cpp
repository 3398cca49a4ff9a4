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

/// Clamps a value to 0 to 255. NaN becomes 0.
template <typename T>
std::uint32_t to_channel(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (!(value > 0)) return 0;  // The comparison is false for NaN.
    return value < 255 ? static_cast<std::uint32_t>(std::lround(value)) : 255;
  } else if constexpr (sizeof(T) == 1 && std::is_unsigned_v<T>) {
    return value;
  } else {
    return static_cast<std::uint32_t>(
        std::clamp(value, T{0}, static_cast<T>(std::min<std::uint64_t>(255, std::numeric_limits<T>::max()))));
  }
}

/// Sets one of the three bytes of each color, which must be 0 before.
void read_channel(const Column& column, unsigned shift, StopCheck& check, std::vector<std::uint32_t>& out) {
  for_each_value(column, out.size(), check, [&](std::size_t i, auto value) { out[i] |= to_channel(value) << shift; });
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

absl::Status read_label(const Column& column, StopCheck& check, std::vector<std::uint32_t>& out) {
  std::string fault;
  for_each_value(column, out.size(), check, [&](std::size_t i, auto value) {
    const auto label = to_label(value);
    if (!label && fault.empty()) {
      fault = fmt::format("point {} (counted from 0) has the label {}, which is not a 32-bit integer", i, value);
    }
    out[i] = label.value_or(0);
  });
  return fault.empty() ? absl::OkStatus() : absl::InvalidArgumentError(fault);
}

}  // namespace

std::vector<std::size_t> FieldRoles::fields() const {
  std::vector<std::size_t> all(position.begin(), position.end());
  if (packed) all.push_back(*packed);
  if (channels) all.insert(all.end(), channels->begin(), channels->end());
  if (label) all.push_back(*label);
  return all;
}

absl::StatusOr<std::optional<std::size_t>> find_unique(const std::vector<std::string_view>& names,
                                                       std::string_view name) {
  const auto first = std::find(names.begin(), names.end(), name);
  if (first == names.end()) return std::nullopt;
  if (std::find(first + 1, names.end(), name) != names.end()) {
    return absl::InvalidArgumentError(fmt::format("'{}' occurs twice", name));
  }
  return static_cast<std::size_t>(first - names.begin());
}

absl::StatusOr<std::optional<std::array<std::size_t, 3>>> find_triple(const std::vector<std::string_view>& names,
                                                                      const std::array<std::string_view, 3>& wanted) {
  std::array<std::size_t, 3> found{};
  bool complete = true;
  for (std::size_t i = 0; i < 3; ++i) {
    ASSIGN_OR_RETURN(const std::optional<std::size_t> index, find_unique(names, wanted[i]));
    complete = complete && index.has_value();
    found[i] = index.value_or(0);
  }
  if (!complete) return std::nullopt;
  return found;
}

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
    for (unsigned i = 0; i < 3; ++i) read_channel(column((*roles.channels)[i]), 16 - 8 * i, check, cloud.rgb);
  }
  if (roles.label && !check.stopped()) {
    out.label.resize(points);
    RETURN_IF_ERROR(read_label(column(*roles.label), check, out.label));
  }
  return check.status();
}

std::string given_view_rule(const View& view) {
  return view.kind == ViewKind::kCamera ? "CAMERA, as asked for" : "WORLD, as asked for";
}

}  // namespace segserve::codec
