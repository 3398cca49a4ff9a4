// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/codec/rgbd/png_image.hpp"

// JPEG images from untrusted bytes, as png_image.hpp. Decoded by libjpeg-turbo's exact integer transform, which gives
// the same pixels on every CPU.
namespace segserve::codec {

bool is_jpeg(std::string_view bytes);

/// INVALID_ARGUMENT also for images that could be decoded only in part.
absl::StatusOr<ColorImage> decode_jpeg(std::string_view bytes, const DecodeLimits& limits);

/// `quality` is 1 to 100. Color has half of the resolution (4:2:0).
absl::StatusOr<std::string> encode_jpeg(const ColorImage& image, int quality);

}  // namespace segserve::codec
