// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <variant>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/image_pixels.hpp"

namespace segserve::codec {

/// A decoded depth image, in units of depth.
using DepthImage = std::variant<GrayImage, FloatImage>;

inline const ImageSize& size_of(const DepthImage& image) {
  return std::visit([](const auto& pixels) -> const ImageSize& { return pixels.size; }, image);
}

/// Decodes the depth image of RgbdImages. Its size is also compared with the limits as that of the cloud that it
/// becomes. Errors are those of the reader of its format.
absl::StatusOr<DepthImage> decode_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

}  // namespace segserve::codec
