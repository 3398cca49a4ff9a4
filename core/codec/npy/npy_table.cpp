// SPDX-License-Identifier: Apache-2.0
#include "core/codec/npy/npy_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/packed_color_column.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/common/unnamed_columns.hpp"
#include "core/codec/npy/half_float.hpp"

namespace segserve::codec {
namespace {

using Names = std::array<const char*, 3>;
constexpr Names kPosition{"x", "y", "z"}, kColor{"red", "green", "blue"};

}  // namespace

const Names* NpyTable::parts_of(std::string_view name, std::size_t count) const {
  constexpr std::array<std::string_view, 8> kColors{"colors", "color", "colours",      "colour",
                                                    "rgb",    "rgba",  "vertex_color", "vertex_colors"};
  const std::string lower = lower_case(name);
  const Names* parts = nullptr;
  if ((count == 3 || count == 4) && lower == "arr_1") parts = &kColor;  // np.savez(file, points, colors)
  if (count == 3 && std::ranges::find(kPositionArrays, lower) != kPositionArrays.end()) parts = &kPosition;
  if ((count == 3 || count == 4) && std::ranges::find(kColors, lower) != kColors.end()) parts = &kColor;
  const bool is_taken = parts != nullptr && std::ranges::find(names_, (*parts)[0]) != names_.end();
  return is_taken ? nullptr : parts;
}

absl::Status NpyTable::set_shape(const NpyArray& array, std::size_t column_axes) {
  const auto& shape = array.header().shape;
  if (shape.size() < 1 + column_axes || shape.size() > 2 + column_axes) {
    return absl::InvalidArgumentError(fmt::format(
        "{}: its shape is {}; points have the shape (N, 3) or (H, W, 3), or (N) or (H, W) with named fields",
        array.name(), shape_text(array.header())));
  }
  const bool is_organized = shape.size() == 2 + column_axes;
  const std::uint64_t width = is_organized ? shape[1] : shape[0], height = is_organized ? shape[0] : 1;
  RETURN_IF_ERROR(check_points(array.name() + ": ", saturating_product(width, height), limits_));
  if (std::max(width, height) > kMaxPoints) {
    return absl::InvalidArgumentError(fmt::format("{}: its shape is {}", array.name(), shape_text(array.header())));
  }
  width_ = static_cast<std::uint32_t>(width);
  height_ = static_cast<std::uint32_t>(height);
  return absl::OkStatus();
}

bool NpyTable::fits(const NpyArray& array) const {
  const auto& shape = array.header().shape;
  if (array.header().is_structured || shape.empty()) return false;
  if (shape[0] == points()) return shape.size() <= 2;
  return shape.size() >= 2 && shape.size() <= 3 && shape[0] == height_ && shape[1] == width_;
}

void NpyTable::add_column(std::string name, const NpyField& field, const std::byte* data, std::size_t stride,
                          std::size_t count) {
  names_.push_back(std::move(name));
  const std::string& kept = names_.back();
  if (field.kind == NpyKind::kOther) {
    const bool is_padding = kept.empty();
    if (is_padding) return;
    warnings_.push_back({WarningReason::kAttributeNotKept,
                         fmt::format("the values of {} are not kept, because they are no numbers", quoted(kept))});
    return;
  }
  if (field.kind == NpyKind::kNumber) {
    fields_.push_back({kept, field.type, count});
    columns_.push_back({data, stride, field.type, field.order});
    return;
  }
  std::vector<float>& values = halves_.emplace_back(points() * count);
  check_.for_each(0, points(), [&](std::size_t i) {
    for (std::size_t k = 0; k < count; ++k) {
      values[i * count + k] = half_value(load<std::uint16_t>(data + i * stride + 2 * k, field.order));
    }
  });
  fields_.push_back({kept, ScalarType::kFloat32, count});
  columns_.push_back({reinterpret_cast<const std::byte*>(values.data()), count * sizeof(float), ScalarType::kFloat32});
}

void NpyTable::add_fields(const NpyArray& array) {
  const std::size_t stride = array.header().element_bytes;
  for (const NpyField& field : array.header().fields) {
    stated_.take(field.title);
    const std::byte* const data = array.data() + field.offset;
    if (const Names* const parts = parts_of(field.name, field.count)) {
      for (std::size_t k = 0; k < 3; ++k) add_column((*parts)[k], field, data + k * field.bytes, stride, 1);
    } else if (field.count > 0) {
      add_column(lower_case(field.name) == "labels" ? "label" : field.name, field, data, stride, field.count);
    }
  }
}

bool NpyTable::add_points_with_color(const NpyArray& array) {
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  const NpyField& field = array.header().fields[0];
  if (field.kind != NpyKind::kNumber || field.type != ScalarType::kFloat32) return false;
  const std::size_t stride = 4 * field.bytes;
  const std::byte* const color = array.data() + 3 * field.bytes;
  const FloatColor kind = float_color({color, stride, field.type, field.order}, points(), check_);
  if (kind == FloatColor::kNone) return false;
  for (std::size_t k = 0; k < 3; ++k) add_column(kAxes[k], field, array.data() + k * field.bytes, stride, 1);
  if (kind == FloatColor::kPacked) {
    add_column("rgb", field, color, stride, 1);
    return true;
  }
  const bool is_reversed = field.order == std::endian::big;
  names_.emplace_back(is_reversed ? "bgr" : "rgba");
  fields_.push_back({names_.back(), ScalarType::kUint8, is_reversed ? 3U : 4U});
  columns_.push_back({color + (is_reversed ? 1 : 0), stride, ScalarType::kUint8});
  warnings_.push_back({WarningReason::kOther,
                       fmt::format("{}: the bits of the fourth numbers are taken as colors, red in the first byte, as "
                                   "cameras of ZED have them",
                                   array.name())});
  return true;
}

absl::Status NpyTable::add_unnamed(const NpyArray& array) {
  constexpr std::uint64_t kMostColumns = 64;
  const NpyHeader& header = array.header();
  const std::uint64_t count = header.shape.back();
  if (!array.turned_shape().empty()) {
    warnings_.push_back(
        {WarningReason::kOther, fmt::format("{}: its shape is {}; the axis of {} is taken as that of the coordinates",
                                            array.name(), array.turned_shape(), count)});
  }
  if (count < 3 || count > kMostColumns) {
    return absl::InvalidArgumentError(fmt::format(
        "{}: its shape is {}; the last axis must have 3 to {} entries, x, y and z first; a depth image goes "
        "into a PNG or PFM for --depth",
        array.name(), shape_text(header), kMostColumns));
  }
  const NpyField& field = header.fields[0];
  if (field.kind == NpyKind::kOther) {
    return absl::InvalidArgumentError(fmt::format("{}: its elements are no numbers", array.name()));
  }
  const std::size_t first = columns_.size(), stride = static_cast<std::size_t>(count) * field.bytes;
  if (count == 4 && add_points_with_color(array)) return absl::OkStatus();
  for (std::size_t k = 0; k < count; ++k) add_column("", field, array.data() + k * field.bytes, stride, 1);
  const std::vector<Column> added(columns_.begin() + static_cast<std::ptrdiff_t>(first), columns_.end());
  const std::vector<std::string> names = name_columns(added, points(), check_, warnings_);
  for (std::size_t k = 0; k < count; ++k) {
    names_.push_back(names[k]);
    fields_[first + k].name = names_.back();
  }
  return absl::OkStatus();
}

void NpyTable::add_named(const NpyArray& array, const std::string& name) {
  const NpyField& field = array.header().fields[0];
  std::size_t total = 1;
  if (points() > 0) total = static_cast<std::size_t>(array.header().elements()) / points();
  if (const Names* const parts = parts_of(name, total)) {
    for (std::size_t k = 0; k < 3; ++k) {
      add_column((*parts)[k], field, array.data() + k * field.bytes, total * field.bytes, 1);
    }
  } else if (total > 0) {
    add_column(lower_case(name) == "labels" ? "label" : name, field, array.data(), total * field.bytes, total);
  }
}

absl::StatusOr<PointTable> NpyTable::finish() {
  PointTable table;
  table.fields = fields_;
  auto roles = find_field_roles(table.fields, warnings_);
  if (!roles.ok()) {
    std::vector<std::string> names;
    names.reserve(fields_.size());
    for (const Field& field : fields_) names.push_back(quoted(field.name));
    return absl::InvalidArgumentError(
        fmt::format("{}; its fields are {}", message_of(roles.status()), fmt::join(names, ", ")));
  }
  table.roles = *std::move(roles);
  table.width = width_;
  table.height = height_;
  table.stated = stated_;
  table.column = [this](std::size_t i) { return columns_[i]; };
  return table;
}

}  // namespace segserve::codec
