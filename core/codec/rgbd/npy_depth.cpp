// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/npy_depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/codec/common/column.hpp"
#include "core/codec/npy/half_float.hpp"
#include "core/codec/npy/npy_array.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kName = "NPY";

absl::StatusOr<DepthFormat> format_of(const NpyHeader& header) {
  std::vector<std::uint64_t> shape = header.shape;
  if (shape.size() == 3 && shape.back() == 1) shape.pop_back();
  if (shape.size() == 3 && shape.front() == 1) shape.erase(shape.begin());
  constexpr std::uint64_t kMostPixels = std::numeric_limits<std::int32_t>::max();
  if (header.is_structured || shape.size() != 2 || std::ranges::max(shape) > kMostPixels) {
    return absl::InvalidArgumentError(
        fmt::format("{}: its shape is {}, but a depth image has (height, width)", kName, shape_text(header)));
  }
  const NpyField& field = header.fields[0];
  const bool is_number = field.kind == NpyKind::kNumber;
  DepthFormat format{.width = static_cast<std::uint32_t>(shape[1]), .height = static_cast<std::uint32_t>(shape[0])};
  format.floats = field.kind == NpyKind::kHalf || (is_number && is_float(field.type));
  if (format.floats || (is_number && field.type == ScalarType::kUint16)) return format;
  return absl::InvalidArgumentError(
      fmt::format("{}: depth must be floats, or integers of 16 bits without a sign (uint16)", kName));
}

}  // namespace

absl::StatusOr<DepthFormat> npy_depth_format(std::string_view bytes) {
  ASSIGN_OR_RETURN(const NpyHeader header, parse_npy_header(bytes, std::string(kName)));
  return format_of(header);
}

absl::StatusOr<DepthImage> decode_npy_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check) {
  ASSIGN_OR_RETURN(const DepthFormat format, npy_depth_format(bytes));
  const ImageSize size{format.width, format.height};
  RETURN_IF_ERROR(check_image_size(size, sizeof(double), limits));
  ASSIGN_OR_RETURN(const NpyArray array, NpyArray::open(std::as_bytes(std::span(bytes)), std::string(kName), check));
  const NpyField& field = array.header().fields[0];
  const Column column{array.data(), field.bytes, field.type, field.order};
  if (!format.floats) {
    GrayImage image{size, std::vector<std::uint16_t>(size.pixels())};
    check.for_each(0, image.pixels.size(), [&](std::size_t i) {
      image.pixels[i] = load<std::uint16_t>(array.data() + i * field.bytes, field.order);
    });
    RETURN_IF_ERROR(check.status());
    return image;
  }
  FloatImage image{size, std::vector<float>(size.pixels())};
  if (field.kind == NpyKind::kHalf) {
    check.for_each(0, image.pixels.size(), [&](std::size_t i) {
      image.pixels[i] = half_value(load<std::uint16_t>(array.data() + i * field.bytes, field.order));
    });
  } else {
    for_each_value(column, image.pixels.size(), check,
                   [&image](std::size_t i, auto value) { image.pixels[i] = static_cast<float>(value); });
  }
  RETURN_IF_ERROR(check.status());
  return image;
}

}  // namespace segserve::codec
