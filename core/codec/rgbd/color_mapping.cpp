// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/color_mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/status_macros.hpp"

namespace segserve::codec {
namespace {

/// A side of an image: its pixels, focal length and center.
struct Axis {
  std::uint32_t pixels;
  double focal;
  double center;
};

std::vector<std::uint32_t> nearest_pixels(const Axis& depth, const Axis& color) {
  std::vector<std::uint32_t> nearest(depth.pixels, ColorMapping::kOutside);
  for (std::uint32_t u = 0; u < depth.pixels; ++u) {
    const double pixel = std::floor((u - depth.center) / depth.focal * color.focal + color.center + 0.5);
    if (pixel >= 0 && pixel < color.pixels) nearest[u] = static_cast<std::uint32_t>(pixel);
  }
  return nearest;
}

/// The nearest pixels if both images show the same part of the scene: floor((u + 1/2) * to / from), in integers.
std::vector<std::uint32_t> scaled_pixels(std::uint32_t from, std::uint32_t to) {
  std::vector<std::uint32_t> nearest(from);
  for (std::uint32_t u = 0; u < from; ++u) {
    nearest[u] = static_cast<std::uint32_t>((2 * std::uint64_t{u} + 1) * to / (2 * std::uint64_t{from}));
  }
  return nearest;
}

/// INVALID_ARGUMENT if a side of an image differs by more than a pixel from that of the other one, scaled to its size.
absl::Status check_proportions(const ImageSize& depth, const ImageSize& color) {
  const std::uint64_t a = std::uint64_t{depth.width} * color.height, b = std::uint64_t{depth.height} * color.width;
  const std::uint64_t difference = a > b ? a - b : b - a;
  if (difference <= std::min({depth.width, depth.height, color.width, color.height})) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format(
      "it has {} x {} pixels, and the depth image {} x {}: images of other proportions do not show the same "
      "part of the scene; give the intrinsics of the color image (rgb_intrinsics)",
      color.width, color.height, depth.width, depth.height));
}

}  // namespace

absl::StatusOr<ColorMapping> map_colors(const ImageSize& depth, const ImageSize& color, const Intrinsics& intrinsics,
                                        const std::optional<Intrinsics>& color_intrinsics) {
  if (!color_intrinsics) {
    RETURN_IF_ERROR(check_proportions(depth, color));
    return ColorMapping{scaled_pixels(depth.width, color.width), scaled_pixels(depth.height, color.height)};
  }
  const Intrinsics& from = intrinsics;
  const Intrinsics& to = *color_intrinsics;
  return ColorMapping{nearest_pixels({depth.width, from.fx, from.cx}, {color.width, to.fx, to.cx}),
                      nearest_pixels({depth.height, from.fy, from.cy}, {color.height, to.fy, to.cy})};
}

}  // namespace segserve::codec
