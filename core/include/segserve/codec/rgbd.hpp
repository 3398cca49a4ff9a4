// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
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

/// INVALID_ARGUMENT unless the scale is above 0 and at most 1. `depth_scale` is in meters per unit of depth; a larger
/// number is mostly meant as units per meter, and the message says what that would be.
absl::Status check_depth_scale(double depth_scale);

/// The image files of one view, as bytes in memory of somebody else.
struct RgbdImages {
  /// The depth along the camera's z axis, in one of these formats:
  /// - PNG, gray with 16 bits, or PGM (P2, P5) with a largest value above 255. 0 and 65535 mean that there is no point.
  /// - PFM, gray (Pf). Numbers that are not finite or not above 0 mean that there is no point. The amount of the scale
  /// in
  ///   its header is not used, because programs disagree about what it means.
  /// - NPY, an array (H, W) of uint16, which means what it does in a PNG, or of floats, which mean what they do in a
  /// PFM. Readers of other formats, such as TIFF, have known faults with hostile bytes; segctl turns TIFF into these.
  std::string_view depth;
  /// The color as seen from the place of the depth image: PNG of any kind, JPEG (gray, color, CMYK), PGM or PPM. Empty
  /// if there is no color.
  std::string_view color;
  double depth_scale = 0;  ///< meters per unit of depth
  Intrinsics intrinsics;   ///< of the depth image
  /// The intrinsics of the color image; unset if both images show the same part of the scene.
  std::optional<Intrinsics> color_intrinsics = std::nullopt;
};

/// The format that the first bytes of a depth image claim.
struct DepthFormat {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool floats = false;  ///< whether its pixels are floats, mostly meters; otherwise 16-bit integers, mostly millimeters
  double header_scale = 1;  ///< the amount of the scale in the header of a PFM, which decode_rgbd does not use

  /// The scale of the images that most programs write: 1 for floats, 0.001 for integers.
  double usual_scale() const { return floats ? 1 : 0.001; }
};

/// INVALID_ARGUMENT if the bytes do not begin as one of the formats of RgbdImages::depth.
absl::StatusOr<DepthFormat> depth_format(std::string_view depth);

/// Decodes the images into a cloud with one point per pixel, in the camera frame, meters. A pixel (u, v) of depth d
/// becomes the point
///
///     z = d * depth_scale,  x = (u - cx) / fx * z,  y = (v - cy) / fy * z,
///
/// computed in double from left to right and rounded to float. A pixel without depth becomes NaN.
///
/// The color of the point is that of the nearest pixel of the color image to
///
///     u' = (u - cx) / fx * fx' + cx',  v' = (v - cy) / fy * fy' + cy',
///
/// where the color image's intrinsics fx', fy', cx', cy' are those of the depth image, scaled to the size of the color
/// image, if they are unset: u' + 1/2 = (u + 1/2) * width' / width. Points that the color image does not show are
/// black.
///
/// Warnings tell of damaged images, of pixels that are 65535 or negative, of points without color, of intrinsics that
/// hardly fit the size of their image, and of a PFM whose header has a scale other than 1 and `depth_scale`.
///
/// INVALID_ARGUMENT that names a wrong number of the camera, or the image ("depth: .." or "color: ..") and its fault,
/// wrong size or exceeded limit. If `color_intrinsics` is unset, color images of other proportions than the depth image
/// are refused. The size of each image is compared with the limits before memory is allocated for it. CANCELLED and
/// DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<LabeledCloud> decode_rgbd(const RgbdImages& images, const DecodeLimits& limits,
                                         const StopToken& stop = {});

}  // namespace segserve::codec
