// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd_encode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "core/codec/rgbd/image_size.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::codec {
namespace {

constexpr double kMostDepth = 65535;
constexpr double kMostDeviation = 0.5;  // pixels

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

/// Least squares of pixel = focal * slope + center.
struct Line {
  double count = 0, slope = 0, pixel = 0, slope_slope = 0, slope_pixel = 0;

  void add(double s, double p) {
    count += 1;
    slope += s;
    pixel += p;
    slope_slope += s * s;
    slope_pixel += s * p;
  }
  /// Focal length and center; not finite if they are not determined.
  std::pair<double, double> solve() const {
    const double focal = (count * slope_pixel - slope * pixel) / (count * slope_slope - slope * slope);
    return {focal, (pixel - focal * slope) / count};
  }
};

absl::Status beyond_depth(double z, double depth_scale) {
  return absl::InvalidArgumentError(fmt::format(
      "a point with z = {} m does not fit into 1 to {} units of depth of {} m", z, kMostDepth, depth_scale));
}

absl::StatusOr<std::vector<std::uint16_t>> depth_pixels(const CloudView& cloud, double depth_scale) {
  std::vector<std::uint16_t> pixels(cloud.size());
  absl::Status status;
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double, double, double z) {
    const double units = std::max(1.0, std::floor(z / depth_scale + 0.5));
    if (!(z > 0 && units <= kMostDepth)) {
      if (status.ok()) status = beyond_depth(z, depth_scale);
      return;
    }
    pixels[std::size_t{v} * cloud.width + u] = static_cast<std::uint16_t>(units);
  });
  if (!status.ok()) return status;
  return pixels;
}

/// The largest distance along an axis between a point and what its pixel will become.
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
  if (absl::Status status = check_is_image(cloud); !status.ok()) return status;
  Line columns;
  Line rows;
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double x, double y, double z) {
    columns.add(x / z, u);
    rows.add(y / z, v);
  });
  Intrinsics camera;
  std::tie(camera.fx, camera.cx) = columns.solve();
  std::tie(camera.fy, camera.cy) = rows.solve();
  if (!check_intrinsics(camera).ok()) {
    return absl::InvalidArgumentError("the points do not tell the camera: they are too few, or no image of one");
  }
  double deviation = 0;  // pixels
  for_each_point(cloud, [&](std::uint32_t u, std::uint32_t v, double x, double y, double z) {
    deviation =
        std::max({deviation, std::abs(camera.fx * x / z + camera.cx - u), std::abs(camera.fy * y / z + camera.cy - v)});
  });
  if (deviation <= kMostDeviation) return camera;
  return absl::InvalidArgumentError(
      fmt::format("the points are no image of a pinhole camera: one is {:.3g} pixels away from its own", deviation));
}

absl::StatusOr<RgbdFiles> encode_rgbd(const CloudView& cloud, const RgbdOptions& options) {
  if (absl::Status status = check_is_image(cloud); !status.ok()) return status;
  if (absl::Status status = check_depth_scale(options.depth_scale); !status.ok()) return status;
  const auto camera = options.intrinsics ? absl::StatusOr<Intrinsics>(*options.intrinsics) : estimate_intrinsics(cloud);
  if (!camera.ok()) return camera.status();
  if (absl::Status status = check_intrinsics(*camera); !status.ok()) return status;

  RgbdFiles files;
  files.depth_scale = options.depth_scale;
  files.intrinsics = *camera;
  const auto depth = depth_pixels(cloud, options.depth_scale);
  if (!depth.ok()) return depth.status();
  files.error_bound = largest_error(cloud, *depth, files);
  absl::StatusOr<std::string> png = encode_png_gray16({cloud.width, cloud.height}, *depth);
  if (!png.ok()) return png.status();
  files.depth = *std::move(png);
  if (!cloud.has_color()) return files;
  absl::StatusOr<std::string> jpeg = encode_color(cloud, options.jpeg_quality);
  if (!jpeg.ok()) return jpeg.status();
  files.color = *std::move(jpeg);
  return files;
}

}  // namespace segserve::codec
