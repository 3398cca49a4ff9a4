// SPDX-License-Identifier: Apache-2.0
#include "client/recording/images/recorded_color.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "core/codec/rgbd/png_image.hpp"

namespace segserve::recording {
namespace {

/// Where the channels of a pixel are.
struct PixelLayout {
  std::string_view encoding;
  std::size_t bytes, red, green, blue;
};

constexpr std::array<PixelLayout, 7> kLayouts{{{"rgb8", 3, 0, 1, 2},
                                               {"bgr8", 3, 2, 1, 0},
                                               {"8UC3", 3, 2, 1, 0},
                                               {"rgba8", 4, 0, 1, 2},
                                               {"bgra8", 4, 2, 1, 0},
                                               {"mono8", 1, 0, 0, 0},
                                               {"8UC1", 1, 0, 0, 0}}};

}  // namespace

absl::StatusOr<codec::ColorImage> decode_color(const RawImage& image, const codec::DecodeLimits& limits) {
  const auto* layout = std::ranges::find(kLayouts, image.encoding, &PixelLayout::encoding);
  if (layout == kLayouts.end()) {
    return absl::InvalidArgumentError(fmt::format(
        "color images of encoding '{}' are not read; rgb8, bgr8, rgba8, bgra8 and mono8 are", image.encoding));
  }
  codec::ColorImage color{{image.width, image.height}, {}};
  RETURN_IF_ERROR(codec::check_image_size(color.size, 3, limits));
  if (image.step < image.width * layout->bytes || image.data.size() / std::max(1U, image.step) < image.height) {
    return absl::InvalidArgumentError(fmt::format("the color image has {} bytes, too few for {} rows of {}",
                                                  image.data.size(), image.height, image.step));
  }
  color.rgb.reserve(3 * color.size.pixels());
  for (std::uint32_t row = 0; row < image.height; ++row) {
    const char* pixel = image.data.data() + std::size_t{row} * image.step;
    for (std::uint32_t column = 0; column < image.width; ++column, pixel += layout->bytes) {
      for (const std::size_t channel : {layout->red, layout->green, layout->blue}) {
        color.rgb.push_back(static_cast<std::uint8_t>(pixel[channel]));
      }
    }
  }
  return color;
}

absl::StatusOr<codec::JpegImage> decode_color(const CompressedImage& image, const codec::DecodeLimits& limits,
                                              const StopToken& stop) {
  StopCheck check(stop);
  if (codec::is_png(image.data)) {
    ASSIGN_OR_RETURN(auto decoded, codec::decode_png_color(image.data, limits, check));
    return codec::JpegImage{std::move(decoded), ""};
  }
  if (codec::is_jpeg(image.data)) return codec::decode_jpeg(image.data, limits, check);
  return absl::InvalidArgumentError(
      fmt::format("color images of format '{}' are not read; JPEG and PNG are", image.format));
}

}  // namespace segserve::recording
