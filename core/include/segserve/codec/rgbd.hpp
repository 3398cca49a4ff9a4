// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

// Turns the depth and color images of an RGB-D camera into an organized CAMERA cloud.
namespace segserve::codec {

/// A pinhole camera without distortion, in pixels. The center of the first pixel is (0, 0).
struct Intrinsics {
  double fx = 0;  ///< focal lengths
  double fy = 0;
  double cx = 0;  ///< principal point
  double cy = 0;
  bool operator==(const Intrinsics&) const = default;
};

/// INVALID_ARGUMENT unless all numbers are finite, and fx and fy are above 0. The message names every wrong one.
absl::Status check_intrinsics(const Intrinsics& intrinsics);

/// INVALID_ARGUMENT unless the scale is finite and above 0. `depth_scale` is in meters per unit of depth.
absl::Status check_depth_scale(double depth_scale);

/// The image files of one view, as bytes in memory of somebody else.
struct RgbdImages {
  std::string_view depth;  ///< PNG, gray, 16 bits: depth along the camera's z axis; 0 means that there is no point
  std::string_view color;  ///< PNG or JPEG of the same size, aligned with the depth; empty if there is no color
  double depth_scale = 0;  ///< meters per unit of depth
  Intrinsics intrinsics;
};

/// Decodes the images into a cloud with one point per pixel, in the camera frame, meters. A pixel (u, v) of depth d > 0
/// becomes the point
///
///     z = d * depth_scale,  x = (u - cx) / fx * z,  y = (v - cy) / fy * z,
///
/// computed in double from left to right and rounded to float. A pixel of depth 0 becomes NaN. INVALID_ARGUMENT that
/// names a wrong number of the camera, or the image and its fault, wrong size or exceeded limit. The size of each image
/// is compared with the limits before memory is allocated for it. CANCELLED and DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<Cloud> decode_rgbd(const RgbdImages& images, const DecodeLimits& limits, const StopToken& stop = {});

}  // namespace segserve::codec
