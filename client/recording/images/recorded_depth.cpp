// SPDX-License-Identifier: Apache-2.0
#include "client/recording/images/recorded_depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::recording {
namespace {

constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint64_t kPointBytes = 12;
constexpr double kMetersPerMillimeter = 0.001;
constexpr std::size_t kCompressedDepthHeader = 12;

float from_millimeters(std::uint16_t value, std::uint64_t& largest) {
  constexpr std::uint16_t kInvalid = 0xFFFF;
  largest += value == kInvalid ? 1 : 0;
  if (value == 0 || value == kInvalid) return kNotMeasured;
  return static_cast<float>(value * kMetersPerMillimeter);
}

float from_meters(float value) { return std::isfinite(value) && value > 0 ? value : kNotMeasured; }

/// Calls convert with the T of every pixel, and the image.
template <typename T, typename Convert>
absl::StatusOr<DepthImage> convert_pixels(const RawImage& image, const codec::DecodeLimits& limits,
                                          const StopToken& stop, Convert convert) {
  DepthImage depth{.size = {image.width, image.height}, .meters = {}};
  RETURN_IF_ERROR(codec::check_image_size(depth.size, kPointBytes, limits));
  const std::uint64_t row_bytes = std::uint64_t{image.width} * sizeof(T);
  if (image.step < row_bytes || image.data.size() / std::max(1U, image.step) < image.height) {
    return absl::InvalidArgumentError(
        fmt::format("the image has {} bytes, too few for {} rows of {} ({} x {} pixels {})", image.data.size(),
                    image.height, image.step, image.width, image.height, image.encoding));
  }
  const std::endian order = image.is_bigendian ? std::endian::big : std::endian::little;
  depth.meters.resize(depth.size.pixels());
  const auto* bytes = reinterpret_cast<const std::byte*>(image.data.data());
  float* out = depth.meters.data();
  StopCheck check(stop);
  for (std::uint32_t row = 0; row < image.height && !check.after(image.width); ++row, bytes += image.step) {
    for (std::uint32_t column = 0; column < image.width; ++column) {
      *out++ = convert(codec::load<T>(bytes + std::size_t{column} * sizeof(T), order), depth);
    }
  }
  RETURN_IF_ERROR(check.status());
  return depth;
}

/// The numbers by which compressedDepth keeps a depth in meters: as a / depth + b, a whole number.
struct InverseDepth {
  float a = 0, b = 0;
};

absl::StatusOr<DepthImage> decode_png(std::string_view png, const std::optional<InverseDepth>& inverse,
                                      const codec::DecodeLimits& limits, const StopToken& stop) {
  ASSIGN_OR_RETURN(const codec::ImageSize claimed, codec::png_size(png));
  RETURN_IF_ERROR(codec::check_image_size(claimed, kPointBytes, limits));
  StopCheck check(stop);
  ASSIGN_OR_RETURN(const codec::GrayImage image, codec::decode_png_depth(png, limits, check));
  DepthImage depth{.size = image.size, .meters = std::vector<float>(image.pixels.size())};
  check.for_each(0, image.pixels.size(), [&](std::size_t i) {
    const std::uint16_t pixel = image.pixels[i];
    const bool is_inverse = inverse && pixel != 0;
    depth.meters[i] = is_inverse ? from_meters(inverse->a / (static_cast<float>(pixel) - inverse->b))
                                 : from_millimeters(pixel, depth.largest);
  });
  RETURN_IF_ERROR(check.status());
  return depth;
}

}  // namespace

absl::StatusOr<DepthImage> decode_depth(const RawImage& image, const codec::DecodeLimits& limits,
                                        const StopToken& stop) {
  if (image.encoding == "16UC1" || image.encoding == "mono16") {
    return convert_pixels<std::uint16_t>(image, limits, stop, [](std::uint16_t value, DepthImage& depth) {
      return from_millimeters(value, depth.largest);
    });
  }
  if (image.encoding == "32FC1") {
    return convert_pixels<float>(image, limits, stop, [](float value, DepthImage&) { return from_meters(value); });
  }
  return absl::InvalidArgumentError(
      fmt::format("an image of encoding '{}' is no depth image; 16UC1, mono16 and 32FC1 are", image.encoding));
}

absl::StatusOr<DepthImage> decode_depth(const CompressedImage& image, const codec::DecodeLimits& limits,
                                        const StopToken& stop) {
  if (codec::is_png(image.data)) return decode_png(image.data, std::nullopt, limits, stop);
  if (image.data.size() < kCompressedDepthHeader || !codec::is_png(image.data.substr(kCompressedDepthHeader))) {
    return absl::InvalidArgumentError(
        fmt::format("an image of format '{}' is no depth image; PNG and compressedDepth with PNG are", image.format));
  }
  std::optional<InverseDepth> inverse;
  if (image.format.starts_with("32FC1")) {
    inverse.emplace();
    std::memcpy(&*inverse, image.data.data() + 4, sizeof(InverseDepth));
  }
  return decode_png(image.data.substr(kCompressedDepthHeader), inverse, limits, stop);
}

absl::StatusOr<Cloud> to_cloud(const DepthImage& depth, const codec::Intrinsics& camera, const StopToken& stop) {
  const auto [width, height] = depth.size;
  Cloud cloud;
  cloud.resize(depth.size.pixels(), false);
  cloud.width = width;
  cloud.height = height;
  cloud.view = View::camera();
  StopCheck check(stop);
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < height && !check.after(width); ++v) {
    const double y_per_z = (v - camera.cy) / camera.fy;
    for (std::uint32_t u = 0; u < width; ++u, ++i) {
      const double z = depth.meters[i];
      cloud.x[i] = static_cast<float>((u - camera.cx) / camera.fx * z);
      cloud.y[i] = static_cast<float>(y_per_z * z);
      cloud.z[i] = depth.meters[i];
    }
  }
  RETURN_IF_ERROR(check.status());
  return cloud;
}

}  // namespace segserve::recording
