// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/image_pixels.hpp"

// PNG images. Decoders take untrusted bytes and compare the size with the limits before they allocate memory. They
// return INVALID_ARGUMENT if the size exceeds the limits, or if the image is truncated or damaged, and what `check`
// says once it is stopped.
namespace segserve::codec {

/// Whether the bytes begin with the signature of a PNG file.
bool is_png(std::string_view bytes);

/// The size that the first chunk (IHDR) claims.
absl::StatusOr<ImageSize> png_size(std::string_view bytes);

/// Decodes a gray PNG of 16 bits. Its numbers are kept as they are, even if it declares a gamma. INVALID_ARGUMENT for
/// other kinds of PNG, in words for somebody who has a depth image.
absl::StatusOr<GrayImage> decode_png_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

/// Decodes a PNG of any kind to 8 bits a channel. Palettes and gray are expanded, and alpha is left out.
absl::StatusOr<ColorImage> decode_png_color(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

/// Encodes a gray image of 16 bits. `pixels` has width * height entries. INTERNAL if libpng fails.
absl::StatusOr<std::string> encode_png_gray16(const ImageSize& size, std::span<const std::uint16_t> pixels);

}  // namespace segserve::codec
