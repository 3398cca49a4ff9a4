// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

// The images of an RGB-D camera and the organized CAMERA cloud that they are.
namespace segserve::codec {

/// A pinhole camera without distortion, pixels; the center of the first pixel is (0, 0).
struct Intrinsics {
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  bool operator==(const Intrinsics&) const = default;
};

/// INVALID_ARGUMENT that names every wrong one unless all are finite and fx, fy above 0.
absl::Status check_intrinsics(const Intrinsics& intrinsics);

/// INVALID_ARGUMENT unless finite and above 0. `depth_scale` is meters a unit of depth.
absl::Status check_depth_scale(double depth_scale);

/// Image files as bytes that somebody else owns.
struct RgbdImages {
  std::string_view depth;  ///< PNG, 16 bits, gray; 0 is no point
  std::string_view color;  ///< PNG or JPEG of the same size, aligned with the depth; empty: no color
  double depth_scale = 0;  ///< meters a unit of depth
  Intrinsics intrinsics;
};

/// Pixel (u, v) of depth d > 0 becomes z = d * depth_scale, x = (u - cx) / fx * z, y = (v - cy) / fy * z, computed in
/// double from left to right and rounded to float; d = 0 becomes NaN. INVALID_ARGUMENT that names the image and its
/// fault or size, or the limit; sizes are checked before anything is allocated.
absl::StatusOr<Cloud> decode_rgbd(const RgbdImages& images, const DecodeLimits& limits, const StopToken& stop = {});

}  // namespace segserve::codec
