// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/rgbd.hpp"

// An organized CAMERA cloud back into the images that it was made from.
namespace segserve::codec {

struct RgbdOptions {
  double depth_scale = 0.001;                           ///< meters a unit of depth
  int jpeg_quality = 90;                                ///< of the color, 1 to 100
  std::optional<Intrinsics> intrinsics = std::nullopt;  ///< unset: estimate_intrinsics
};

/// What RgbdImages only looks at.
struct RgbdFiles {
  std::string depth;  ///< PNG
  std::string color;  ///< JPEG; empty: no color
  double depth_scale = 0;
  Intrinsics intrinsics;
  double error_bound = 0;  ///< meters: no decoded coordinate is farther from the cloud's than this

  RgbdImages images() const { return {depth, color, depth_scale, intrinsics}; }
};

/// The pinhole camera that sees each finite point nearest to the center of its pixel (least squares). INVALID_ARGUMENT
/// unless the cloud is organized and CAMERA, has points in several rows and columns, and all of them within half a
/// pixel of their own.
absl::StatusOr<Intrinsics> estimate_intrinsics(const CloudView& cloud);

/// Depth is rounded to the nearest unit, at least 1, and the point moved onto the ray of its pixel; color is lossy.
/// INVALID_ARGUMENT as estimate_intrinsics, for points farther away than 65535 units of depth, and for wrong options.
absl::StatusOr<RgbdFiles> encode_rgbd(const CloudView& cloud, const RgbdOptions& options = {});

}  // namespace segserve::codec
