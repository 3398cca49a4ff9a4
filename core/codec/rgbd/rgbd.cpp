// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/image_size.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::codec {
namespace {

constexpr std::uint64_t kPointBytes = 16;  // A decoded point has 3 floats and a color.

/// Decodes the depth image. Its size is also compared with the limits as that of the cloud that it becomes.
absl::StatusOr<GrayImage> decode_depth(std::string_view bytes, const DecodeLimits& limits) {
  ASSIGN_OR_RETURN(const ImageSize size, png_size(bytes));
  RETURN_IF_ERROR(check_image_size(size, kPointBytes, limits));
  return decode_png_gray16(bytes, limits);
}

absl::StatusOr<ColorImage> decode_color(std::string_view bytes, const DecodeLimits& limits) {
  if (is_png(bytes)) return decode_png_color(bytes, limits);
  if (is_jpeg(bytes)) return decode_jpeg(bytes, limits);
  return absl::InvalidArgumentError("the bytes are neither PNG nor JPEG");
}

void read_colors(const ColorImage& image, StopCheck& check, std::vector<std::uint32_t>& out) {
  out.resize(image.size.pixels());
  const std::uint8_t* rgb = image.rgb.data();
  check.for_each(0, out.size(), [rgb, color = out.data()](std::size_t i) {
    color[i] = pack_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
  });
}

/// The points of the pixels, by the equations of decode_rgbd.
Cloud to_cloud(const GrayImage& depth, double scale, const Intrinsics& camera, StopCheck& check) {
  const auto [width, height] = depth.size;
  Cloud cloud;
  cloud.resize(depth.size.pixels(), false);
  cloud.width = width;
  cloud.height = height;
  cloud.view = View::camera();
  std::vector<double> x_per_z(width);
  for (std::uint32_t u = 0; u < width; ++u) x_per_z[u] = (u - camera.cx) / camera.fx;
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < height && !check.after(width); ++v) {
    const double y_per_z = (v - camera.cy) / camera.fy;
    for (std::uint32_t u = 0; u < width; ++u, ++i) {
      const double z = depth.pixels[i] != 0 ? depth.pixels[i] * scale : std::numeric_limits<double>::quiet_NaN();
      cloud.x[i] = static_cast<float>(x_per_z[u] * z);
      cloud.y[i] = static_cast<float>(y_per_z * z);
      cloud.z[i] = static_cast<float>(z);
    }
  }
  return cloud;
}

}  // namespace

absl::Status check_intrinsics(const Intrinsics& intrinsics) {
  std::string faults;
  const auto check = [&faults](const char* name, double value, bool positive) {
    if (std::isfinite(value) && (value > 0 || !positive)) return;
    faults += fmt::format("{}{} is {}, which is not {}", faults.empty() ? "" : "; ", name, value,
                          positive ? "a finite number above 0" : "finite");
  };
  check("fx", intrinsics.fx, true);
  check("fy", intrinsics.fy, true);
  check("cx", intrinsics.cx, false);
  check("cy", intrinsics.cy, false);
  return faults.empty() ? absl::OkStatus() : absl::InvalidArgumentError(faults);
}

absl::Status check_depth_scale(double depth_scale) {
  if (std::isfinite(depth_scale) && depth_scale > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("the depth scale is {}, which is not a finite number above 0", depth_scale));
}

absl::StatusOr<Cloud> decode_rgbd(const RgbdImages& images, const DecodeLimits& limits, const StopToken& stop) {
  RETURN_IF_ERROR(check_intrinsics(images.intrinsics));
  RETURN_IF_ERROR(check_depth_scale(images.depth_scale));
  const auto depth = decode_depth(images.depth, limits);
  if (!depth.ok()) return with_prefix("depth", depth.status());
  StopCheck check(stop);
  Cloud cloud = to_cloud(*depth, images.depth_scale, images.intrinsics, check);
  RETURN_IF_ERROR(check.status());
  if (images.color.empty()) return cloud;

  const auto color = decode_color(images.color, limits);
  if (!color.ok()) return with_prefix("color", color.status());
  if (color->size != depth->size) {
    return absl::InvalidArgumentError(fmt::format("the color image has {} x {} pixels, but the depth image has {} x {}",
                                                  color->size.width, color->size.height, depth->size.width,
                                                  depth->size.height));
  }
  read_colors(*color, check, cloud.rgb);
  RETURN_IF_ERROR(check.status());
  return cloud;
}

}  // namespace segserve::codec
