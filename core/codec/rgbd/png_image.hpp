// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/rgbd/image_size.hpp"

// PNG images. Decoders take untrusted bytes and compare the size with the limits before they allocate memory. They
// return INVALID_ARGUMENT if the size exceeds the limits, or if the image is truncated or damaged.
namespace segserve::codec {

/// Whether the bytes begin with the signature of a PNG file.
bool is_png(std::string_view bytes);

/// The size that the first chunk (IHDR) claims.
absl::StatusOr<ImageSize> png_size(std::string_view bytes);

/// A gray image of 16 bits a pixel.
struct GrayImage {
  ImageSize size;
  std::vector<std::uint16_t> pixels;  ///< width * height, row by row
};

/// Decodes a gray PNG of 16 bits. Its numbers are kept as they are, even if it declares a gamma. INVALID_ARGUMENT for
/// other kinds of PNG.
absl::StatusOr<GrayImage> decode_png_gray16(std::string_view bytes, const DecodeLimits& limits);

/// A color image of 8 bits a channel.
struct ColorImage {
  ImageSize size;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height: R, G, B of each pixel, row by row
};

/// Decodes a PNG of any kind to 8 bits a channel. Palettes and gray are expanded, and alpha is left out.
absl::StatusOr<ColorImage> decode_png_color(std::string_view bytes, const DecodeLimits& limits);

/// Encodes a gray image of 16 bits. `pixels` has width * height entries. INTERNAL if libpng fails.
absl::StatusOr<std::string> encode_png_gray16(const ImageSize& size, std::span<const std::uint16_t> pixels);

}  // namespace segserve::codec
