// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/rgbd.hpp"

// Turns an organized CAMERA cloud back into the depth and color images of an RGB-D camera.
namespace segserve::codec {

/// How encode_rgbd writes the images.
struct RgbdOptions {
  double depth_scale = 0.001;                           ///< meters per unit of depth
  int jpeg_quality = 90;                                ///< quality of the color image, 1 to 100
  std::optional<Intrinsics> intrinsics = std::nullopt;  ///< the camera; estimate_intrinsics finds it if it is unset
};

/// The image files of one view, which own their bytes. RgbdImages says which formats there are; encode_rgbd makes a PNG
/// and a JPEG of the same size.
struct RgbdFiles {
  std::string depth;
  std::string color;       ///< empty if the cloud has no color
  double depth_scale = 0;  ///< meters per unit of depth
  Intrinsics intrinsics;
  double error_bound = 0;  ///< meters: no decoded coordinate is farther than this from the one that was encoded
  std::optional<Intrinsics> color_intrinsics = std::nullopt;  ///< unset if both images show the same part of the scene

  /// Views the images as decode_rgbd takes them. The result is valid as long as this object is.
  RgbdImages images() const { return {depth, color, depth_scale, intrinsics, color_intrinsics}; }
};

/// Finds the pinhole camera whose projection of each finite point lies closest to the center of the point's pixel, in
/// the sense of least squares. INVALID_ARGUMENT unless the cloud is organized with a CAMERA view, its finite points lie
/// in several rows and columns, and the camera sees each of them within half a pixel of its own pixel.
absl::StatusOr<Intrinsics> estimate_intrinsics(const CloudView& cloud);

/// Encodes a cloud as images. Depth is rounded to the nearest unit, and is at least 1. The decoded point lies on the
/// ray of its pixel. Color loses precision. INVALID_ARGUMENT for a wrong option, for a cloud that is not organized or
/// has no CAMERA view, for the errors of estimate_intrinsics if the options leave the camera open, and for a point that
/// is not in front of the camera or farther away than 65534 units of depth (65535 means that there is no point).
absl::StatusOr<RgbdFiles> encode_rgbd(const CloudView& cloud, const RgbdOptions& options = {});

}  // namespace segserve::codec
