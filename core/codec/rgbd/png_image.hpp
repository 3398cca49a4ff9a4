// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/rgbd/image_size.hpp"

// PNG images from untrusted bytes. Their size is checked against the limits before anything is allocated; a truncated
// or damaged image is INVALID_ARGUMENT.
namespace segserve::codec {

bool is_png(std::string_view bytes);

/// What the first chunk (IHDR) says.
absl::StatusOr<ImageSize> png_size(std::string_view bytes);

struct GrayImage {
  ImageSize size;
  std::vector<std::uint16_t> pixels;  ///< row by row
};

/// A gray PNG of 16 bits, its numbers as they are, whatever it says of gamma. INVALID_ARGUMENT for other PNGs.
absl::StatusOr<GrayImage> decode_png_gray16(std::string_view bytes, const DecodeLimits& limits);

struct ColorImage {
  ImageSize size;
  std::vector<std::uint8_t> rgb;  ///< R, G, B of each pixel
};

/// Any PNG in 8 bits a channel: palettes and gray are expanded, alpha is left out.
absl::StatusOr<ColorImage> decode_png_color(std::string_view bytes, const DecodeLimits& limits);

/// `pixels` has width * height entries. INTERNAL if libpng fails.
absl::StatusOr<std::string> encode_png_gray16(const ImageSize& size, std::span<const std::uint16_t> pixels);

}  // namespace segserve::codec
