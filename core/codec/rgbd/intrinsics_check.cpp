// SPDX-License-Identifier: Apache-2.0
#include "core/codec/rgbd/intrinsics_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace segserve::codec {
namespace {

/// Where the principal point is between the first (0) and the last (1) edge of a side. Pixels have their centers at
/// whole numbers.
double place(double center, std::uint32_t side) { return (center + 0.5) / side; }

bool is_inside(double place) { return place >= 0 && place <= 1; }

/// Whether the place is far from the middle. The lenses of cameras are within a tenth of it.
bool is_aside(double place) { return std::abs(place - 0.5) > 0.2; }

/// The size of the image whose middle the principal point is, if it has the proportions of this one.
std::string other_size(const Intrinsics& intrinsics, double x, double y) {
  constexpr double kSame = 1.15, kMost = 1e6;
  const bool is_scaled = x > 0 && y > 0 && std::max(x / y, y / x) < kSame && std::abs(x - 0.5) > 0.1;
  const double width = std::round(2 * intrinsics.cx + 1), height = std::round(2 * intrinsics.cy + 1);
  if (!is_scaled || std::max(width, height) > kMost) return "";
  return fmt::format("; they look like those of an image of {} x {}", width, height);
}

double field_of_view(double focal, std::uint32_t side) {
  return 2 * std::atan(side / (2 * focal)) * 180 / std::numbers::pi;
}

/// Says which of the intrinsics is odd for an image of this size. The text is empty if none is.
std::string oddity(const Intrinsics& intrinsics, const ImageSize& size) {
  constexpr double kShortest = 0.18, kLongest = 14;  // of the longer side: 140 and 4 degrees
  constexpr double kMostDifferent = 1.5;
  const auto [fx, fy, cx, cy] = intrinsics;
  const double x = place(cx, size.width), y = place(cy, size.height);
  if (!is_inside(x) || !is_inside(y)) {
    return fmt::format("the principal point ({:.6g}, {:.6g}) lies outside{}", cx, cy, other_size(intrinsics, x, y));
  }
  if (is_aside(x) || is_aside(y)) {
    return fmt::format("the principal point ({:.6g}, {:.6g}) is far from the middle{}", cx, cy,
                       other_size(intrinsics, x, y));
  }
  const double relative = std::min(fx / size.width, fy / size.height);
  if (relative < kShortest || relative > kLongest) {
    return fmt::format("the focal lengths {:.6g} and {:.6g} mean a field of view of {:.3g} x {:.3g} degrees", fx, fy,
                       field_of_view(fx, size.width), field_of_view(fy, size.height));
  }
  if (std::max(fx / fy, fy / fx) > kMostDifferent) {
    return fmt::format("the focal lengths {:.6g} and {:.6g} differ much; the order is fx, fy, cx, cy", fx, fy);
  }
  return "";
}

}  // namespace

std::optional<Warning> odd_intrinsics(std::string_view image, const Intrinsics& intrinsics, const ImageSize& size) {
  constexpr std::uint32_t kFewestPixels = 16;
  if (std::min(size.width, size.height) < kFewestPixels) return std::nullopt;
  const std::string found = oddity(intrinsics, size);
  if (found.empty()) return std::nullopt;
  return Warning{WarningReason::kIntrinsicsUnlikely,
                 fmt::format("{}: the intrinsics hardly fit an image of {} x {} pixels, unless it was cropped: {}",
                             image, size.width, size.height, found)};
}

}  // namespace segserve::codec
