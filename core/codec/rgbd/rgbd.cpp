// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/rgbd.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/file/known_formats.hpp"
#include "core/codec/rgbd/color_mapping.hpp"
#include "core/codec/rgbd/depth_image.hpp"
#include "core/codec/rgbd/intrinsics_check.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "core/codec/rgbd/pnm_image.hpp"

namespace segserve::codec {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Pixels that have a depth which is none, apart from 0, NaN and infinity.
struct OddDepths {
  std::uint64_t largest = 0;   ///< 65535
  std::uint64_t negative = 0;  ///< floats only
};

double units_or_nan(std::uint16_t units, OddDepths& odd) {
  odd.largest += units == UINT16_MAX ? 1 : 0;
  return units != 0 && units != UINT16_MAX ? units : kNaN;
}

double units_or_nan(float units, OddDepths& odd) {
  odd.negative += units < 0 ? 1 : 0;
  return units > 0 && std::isfinite(units) ? double{units} : kNaN;
}

/// The points of the pixels, by the equations of decode_rgbd.
template <typename Image>
Cloud to_cloud(const Image& depth, double scale, const Intrinsics& camera, OddDepths& odd, StopCheck& check) {
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
      const double z = units_or_nan(depth.pixels[i], odd) * scale;
      cloud.x[i] = static_cast<float>(x_per_z[u] * z);
      cloud.y[i] = static_cast<float>(y_per_z * z);
      cloud.z[i] = static_cast<float>(z);
    }
  }
  return cloud;
}

void warn_of(const OddDepths& odd, std::uint64_t pixels, std::vector<Warning>& warnings) {
  const auto warn = [&](std::uint64_t count, std::string_view what) {
    if (count == 0) return;
    warnings.push_back({WarningReason::kPointsNotUsed,
                        fmt::format("depth: {} of {} pixels are {}, which is no distance; they become no points", count,
                                    pixels, what)});
  };
  warn(odd.largest, "65535");
  warn(odd.negative, "negative");
}

/// Warns of a scale in the depth image that may be what was meant.
absl::Status warn_of_scale(const RgbdImages& images, std::vector<Warning>& warnings) {
  ASSIGN_OR_RETURN(const DepthFormat format, depth_format(images.depth));
  if (format.header_scale == 1 || format.header_scale == images.depth_scale) return absl::OkStatus();
  warnings.push_back(
      {WarningReason::kScaleNotUsed,
       fmt::format("depth: the scale {:.6g} in the header of the PFM is not used, because programs disagree "
                   "about it; a unit of depth is taken as {:.6g} m",
                   format.header_scale, images.depth_scale)});
  return absl::OkStatus();
}

absl::StatusOr<ColorImage> decode_color(std::string_view bytes, const DecodeLimits& limits, StopCheck& check,
                                        std::vector<Warning>& warnings) {
  if (is_png(bytes)) return decode_png_color(bytes, limits, check);
  if (is_pnm(bytes)) return decode_pnm_color(bytes, limits, check);
  if (!is_jpeg(bytes)) {
    const std::string_view name = format_name(bytes);
    if (name.empty()) return absl::InvalidArgumentError("the bytes are neither PNG nor JPEG nor PPM");
    return absl::InvalidArgumentError(
        fmt::format("this is {}, which is not read as color; PNG, JPEG and PPM are", name));
  }
  ASSIGN_OR_RETURN(JpegImage jpeg, decode_jpeg(bytes, limits, check));
  if (!jpeg.damage.empty()) {
    warnings.push_back({WarningReason::kImageDamaged, fmt::format("color: the JPEG is damaged: {}", jpeg.damage)});
  }
  return std::move(jpeg.image);
}

/// Sets the colors of the points. Returns how many finite points the color image does not show.
std::uint64_t set_colors(const ColorImage& image, const ColorMapping& mapping, StopCheck& check, Cloud& cloud) {
  cloud.rgb.assign(cloud.size(), 0);
  std::uint64_t missing = 0;
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < cloud.height && !check.after(cloud.width); ++v) {
    const std::size_t row = mapping.row[v];
    for (std::uint32_t u = 0; u < cloud.width; ++u, ++i) {
      const std::uint32_t column = mapping.column[u];
      if (row == ColorMapping::kOutside || column == ColorMapping::kOutside) {
        missing += is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) ? 1 : 0;
        continue;
      }
      const std::uint8_t* rgb = image.rgb.data() + 3 * (row * image.size.width + column);
      cloud.rgb[i] = pack_rgb(rgb[0], rgb[1], rgb[2]);
    }
  }
  return missing;
}

absl::Status add_color(const RgbdImages& images, const DecodeLimits& limits, StopCheck& check, LabeledCloud& result) {
  ASSIGN_OR_RETURN(const ColorImage image, decode_color(images.color, limits, check, result.warnings));
  const ImageSize size{result.cloud.width, result.cloud.height};
  ASSIGN_OR_RETURN(const ColorMapping mapping,
                   map_colors(size, image.size, images.intrinsics, images.color_intrinsics));
  const std::uint64_t missing = set_colors(image, mapping, check, result.cloud);
  if (missing != 0) {
    result.warnings.push_back(
        {WarningReason::kColorMissing,
         fmt::format("color: the image does not show {} of {} points; they are black", missing, result.cloud.size())});
  }
  if (!images.color_intrinsics) return check.status();
  if (auto odd = odd_intrinsics("color", *images.color_intrinsics, image.size)) {
    result.warnings.push_back(*std::move(odd));
  }
  return check.status();
}

/// An error of an image begins with its name. Being stopped is no error of an image.
absl::Status named(std::string_view image, const absl::Status& status) {
  return absl::IsInvalidArgument(status) ? with_prefix(image, status) : status;
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
  if (!std::isfinite(depth_scale) || depth_scale <= 0) {
    return absl::InvalidArgumentError(
        fmt::format("the depth scale is {}, which is not a finite number above 0", depth_scale));
  }
  if (depth_scale <= 1) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("the depth scale is {}, but meters a unit of depth are meant; {} units a meter are {:.6g}",
                  depth_scale, depth_scale, 1 / depth_scale));
}

absl::StatusOr<LabeledCloud> decode_rgbd(const RgbdImages& images, const DecodeLimits& limits, const StopToken& stop) {
  RETURN_IF_ERROR(check_intrinsics(images.intrinsics));
  if (images.color_intrinsics) RETURN_IF_ERROR(named("color", check_intrinsics(*images.color_intrinsics)));
  RETURN_IF_ERROR(check_depth_scale(images.depth_scale));
  StopCheck check(stop);
  const auto depth = decode_depth(images.depth, limits, check);
  if (!depth.ok()) return named("depth", depth.status());
  LabeledCloud result;
  result.view_rule = "CAMERA, as RGB-D images are";
  OddDepths odd;
  result.cloud = std::visit(
      [&](const auto& image) { return to_cloud(image, images.depth_scale, images.intrinsics, odd, check); }, *depth);
  RETURN_IF_ERROR(check.status());
  RETURN_IF_ERROR(warn_of_scale(images, result.warnings));
  if (auto unlikely = odd_intrinsics("depth", images.intrinsics, size_of(*depth))) {
    result.warnings.push_back(*std::move(unlikely));
  }
  warn_of(odd, size_of(*depth).pixels(), result.warnings);
  if (!images.color.empty()) RETURN_IF_ERROR(named("color", add_color(images, limits, check, result)));
  return result;
}

}  // namespace segserve::codec
