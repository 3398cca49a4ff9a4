// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "client/recording/images/image_messages.hpp"
#include "core/codec/rgbd/image_pixels.hpp"
#include "core/codec/rgbd/jpeg_image.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::recording {

/// Decodes rgb8, bgr8, rgba8, bgra8, 8UC3 (as bgr8), mono8 and 8UC1. INVALID_ARGUMENT for other encodings, too few
/// bytes and exceeded limits.
absl::StatusOr<codec::ColorImage> decode_color(const RawImage& image, const codec::DecodeLimits& limits);

/// Decodes JPEG and PNG, and says how a JPEG is damaged. INVALID_ARGUMENT for other formats, images of which nothing
/// can be read, and exceeded limits. CANCELLED and DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<codec::JpegImage> decode_color(const CompressedImage& image, const codec::DecodeLimits& limits,
                                              const StopToken& stop);

}  // namespace segserve::recording
