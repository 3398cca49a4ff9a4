// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/image_pixels.hpp"

// JPEG images. libjpeg-turbo decodes them by its exact integer transform, which gives the same pixels on every CPU.
namespace segserve::codec {

/// Whether the bytes begin with the signature of a JPEG file.
bool is_jpeg(std::string_view bytes);

/// A decoded JPEG image.
struct JpegImage {
  ColorImage image;
  std::string damage;  ///< what is wrong with the bytes, and what that costs; empty if nothing is wrong
};

/// Decodes untrusted bytes: gray, color or CMYK, sequential or progressive. The size is compared with the limits before
/// memory is allocated. A damaged image is used, as far as its bytes go; what is missing is gray. INVALID_ARGUMENT if a
/// limit is exceeded, if the bytes are none of these images, or if they end before the first row of pixels. The status
/// of `check` once it is stopped.
absl::StatusOr<JpegImage> decode_jpeg(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

/// Encodes an image. `quality` is 1 to 100; the color channels have half of the resolution (4:2:0). INVALID_ARGUMENT
/// for another quality, or for an image without pixels or with a side of more than 65535. INTERNAL if the library
/// fails.
absl::StatusOr<std::string> encode_jpeg(const ColorImage& image, int quality);

}  // namespace segserve::codec
