// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd_encode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/codec/rgbd/image_size.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::codec {
namespace {

constexpr double kMaxDepth = 65534;    // units of depth: the largest 16-bit number means that there is no point
constexpr double kMaxDeviation = 0.5;  // pixels

absl::Status check_is_image(const CloudView& cloud) {
  if (cloud.view.kind == ViewKind::kCamera && cloud.height > 1) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "only an organized cloud (height above 1) seen from the camera can become RGB-D images");
}

/// Calls function(u, v, x, y, z) for every finite point.
template <typename Function>
void for_each_point(const CloudView& cloud, Function function) {
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < cloud.height; ++v) {
    for (std::uint32_t u = 0; u < cloud.width; ++u, ++i) {
      if (is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) {
        function(u, v, double{cloud.x[i]}, double{cloud.y[i]}, double{cloud.z[i]});
      }
    }
  }
}

/// Fits pixel = focal * slope + center to points, in the sense of least squares.
struct LineFit {
  double count = 0, slope = 0, pixel = 0, slope_slope = 0, slope_pixel = 0;

  void add(double s, double p) {
    count += 1;
    slope += s;
    pixel += p;
    slope_slope += s * s;
    slope_pixel += s * p;
  }
  /// The focal length and the center. They are not finite if the points do not determine them.
  std::pair<double, double> solve() const {
    const double focal = (count * slope_pixel - slope * pixel) / (count * slope_slope - slope * slope);
    return {focal, (pixel - focal * slope) / count};
  }
};

absl::Status depth_out_of_range(double z, double depth_scale) {
  return absl::InvalidArgumentError(
      fmt::format("a point with z = {} m does not fit into 1 to {} units of depth of {} m", z, kMaxDepth, depth_scale));
}

/// The depth of each pixel, in units of depth; 0 where no point is finite.
absl::StatusOr<std::vector<std::uint16_t>> depth_pixels(const CloudView& cloud, double depth_scale) {
  std::vector<std::uint16_t> pixels(cloud.size());
  absl::Status status;
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double, double, double z) {
    const double units = std::max(1.0, std::floor(z / depth_scale + 0.5));
    if (!(z > 0 && units <= kMaxDepth)) {
      if (status.ok()) status = depth_out_of_range(z, depth_scale);
      return;
    }
    pixels[std::size_t{v} * cloud.width + u] = static_cast<std::uint16_t>(units);
  });
  RETURN_IF_ERROR(status);
  return pixels;
}

/// The largest distance along an axis between a point and the one that decode_rgbd will make from its pixel.
double largest_error(const CloudView& cloud, const std::vector<std::uint16_t>& depth, const RgbdFiles& files) {
  const Intrinsics& camera = files.intrinsics;
  double largest = 0;
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double x, double y, double z) {
    const double decoded_z = depth[std::size_t{v} * cloud.width + u] * files.depth_scale;
    const double decoded_x = (u - camera.cx) / camera.fx * decoded_z;
    const double decoded_y = (v - camera.cy) / camera.fy * decoded_z;
    const auto error = [](double a, double b) { return std::abs(a - double{static_cast<float>(b)}); };
    largest = std::max({largest, error(x, decoded_x), error(y, decoded_y), error(z, decoded_z)});
  });
  return largest;
}

absl::StatusOr<std::string> encode_color(const CloudView& cloud, int quality) {
  ColorImage image{{cloud.width, cloud.height}, {}};
  image.rgb.reserve(3 * cloud.size());
  for (const std::uint32_t rgb : cloud.rgb) image.rgb.insert(image.rgb.end(), {red(rgb), green(rgb), blue(rgb)});
  return encode_jpeg(image, quality);
}

}  // namespace

absl::StatusOr<Intrinsics> estimate_intrinsics(const CloudView& cloud) {
  RETURN_IF_ERROR(check_is_image(cloud));
  LineFit columns;
  LineFit rows;
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double x, double y, double z) {
    columns.add(x / z, u);
    rows.add(y / z, v);
  });
  Intrinsics camera;
  std::tie(camera.fx, camera.cx) = columns.solve();
  std::tie(camera.fy, camera.cy) = rows.solve();
  if (!check_intrinsics(camera).ok()) {
    return absl::InvalidArgumentError(
        "the points do not determine the camera: they are too few, or not the image of one");
  }
  double deviation = 0;  // pixels
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double x, double y, double z) {
    deviation =
        std::max({deviation, std::abs(camera.fx * x / z + camera.cx - u), std::abs(camera.fy * y / z + camera.cy - v)});
  });
  if (deviation <= kMaxDeviation) return camera;
  return absl::InvalidArgumentError(fmt::format(
      "the points are not the image of a pinhole camera: one is {:.3g} pixels away from its own pixel", deviation));
}

absl::StatusOr<RgbdFiles> encode_rgbd(const CloudView& cloud, const RgbdOptions& options) {
  RETURN_IF_ERROR(check_is_image(cloud));
  RETURN_IF_ERROR(check_depth_scale(options.depth_scale));
  RgbdFiles files;
  files.depth_scale = options.depth_scale;
  if (options.intrinsics) {
    RETURN_IF_ERROR(check_intrinsics(*options.intrinsics));
    files.intrinsics = *options.intrinsics;
  } else {
    ASSIGN_OR_RETURN(files.intrinsics, estimate_intrinsics(cloud));
  }
  ASSIGN_OR_RETURN(const std::vector<std::uint16_t> depth, depth_pixels(cloud, options.depth_scale));
  files.error_bound = largest_error(cloud, depth, files);
  const ImageSize size{cloud.width, cloud.height};
  ASSIGN_OR_RETURN(files.depth, encode_png_gray16(size, depth));
  if (!cloud.has_color()) return files;
  ASSIGN_OR_RETURN(files.color, encode_color(cloud, options.jpeg_quality));
  return files;
}

}  // namespace segserve::codec
