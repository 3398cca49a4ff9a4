// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "client/recording/images/image_messages.hpp"
#include "core/codec/rgbd/png_image.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::recording {

/// Decodes rgb8, bgr8, rgba8, bgra8, 8UC3 (as bgr8), mono8 and 8UC1. INVALID_ARGUMENT for other encodings, too few
/// bytes and exceeded limits.
absl::StatusOr<codec::ColorImage> decode_color(const RawImage& image, const codec::DecodeLimits& limits);

/// Decodes JPEG and PNG. INVALID_ARGUMENT for other formats, damage and exceeded limits.
absl::StatusOr<codec::ColorImage> decode_color(const CompressedImage& image, const codec::DecodeLimits& limits);

}  // namespace segserve::recording
