// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/codec/rgbd/png_image.hpp"

// JPEG images. libjpeg-turbo decodes them by its exact integer transform, which gives the same pixels on every CPU.
namespace segserve::codec {

/// Whether the bytes begin with the signature of a JPEG file.
bool is_jpeg(std::string_view bytes);

/// Decodes untrusted bytes. The size is compared with the limits before memory is allocated. INVALID_ARGUMENT if it
/// exceeds them, or if the bytes are damaged so that any part of the image is lost.
absl::StatusOr<ColorImage> decode_jpeg(std::string_view bytes, const DecodeLimits& limits);

/// Encodes an image. `quality` is 1 to 100; the color channels have half of the resolution (4:2:0). INVALID_ARGUMENT
/// for another quality, or for an image without pixels or with a side of more than 65535. INTERNAL if the library
/// fails.
absl::StatusOr<std::string> encode_jpeg(const ColorImage& image, int quality);

}  // namespace segserve::codec
