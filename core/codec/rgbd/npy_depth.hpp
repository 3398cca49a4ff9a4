// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "core/codec/rgbd/depth_image.hpp"
#include "segserve/codec/rgbd.hpp"

// Depth images as NumPy's array files, as programs for research keep them.
namespace segserve::codec {

/// INVALID_ARGUMENT unless the header is that of an array of shape (H, W), (H, W, 1) or (1, H, W), of integers of 16
/// bits without a sign, or of floats.
absl::StatusOr<DepthFormat> npy_depth_format(std::string_view bytes);

/// Decodes such an array. Floats of any width become floats of 32 bits. Errors are also those of NpyArray::open, and
/// exceeded limits.
absl::StatusOr<DepthImage> decode_npy_depth(std::string_view bytes, const DecodeLimits& limits, StopCheck& check);

}  // namespace segserve::codec
