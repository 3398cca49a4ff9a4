// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"

namespace segserve::picture {

struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgb;  ///< R, G, B of each pixel, rows from the top: 3 * width * height
};

struct RenderOptions {
  /// Size of the picture of an unorganized cloud in pixels. The picture of an organized cloud has the size of the
  /// cloud.
  std::uint32_t width = 960;
  std::uint32_t height = 720;
  /// Share of the segment's color, 0 to 1. The rest is the point's own color.
  float blend = 0.7F;
  /// Whether thin dark lines separate segments; organized clouds only.
  bool borders = true;
  /// The color, 0x00RRGGBB, where there is no point.
  std::uint32_t background = 0x18181B;
};

/// A picture of the cloud. `labels` has one entry per point, and each segment gets its segment_color. If `labels` is
/// empty, points have their own colors, or light gray shaded by depth if the cloud has no color.
///
/// An organized cloud is shown as its image, row by row. Other clouds are projected point by point with a z-buffer: a
/// CAMERA cloud as seen from the sensor, a WORLD cloud obliquely from above (+z is up), from the side of the sensor if
/// there is one.
Image render(const CloudView& cloud, std::span<const std::uint32_t> labels, const RenderOptions& options = {});

/// The image, at most `max_width` pixels wide: squares of pixels, as small as possible, become their mean. Rows and
/// columns beyond the last whole square are left out, unless nothing would be left.
Image shrink(const Image& image, std::uint32_t max_width);

/// A stable color for a label, 0x00RRGGBB. Consecutive labels look different. Label 0 (no point) is dark gray.
std::uint32_t segment_color(std::uint32_t label);

/// Writes an 8-bit RGB PNG file; "-" is standard output. INVALID_ARGUMENT if the image is empty,
/// PERMISSION_DENIED or NOT_FOUND if the file cannot be opened, UNAVAILABLE if writing fails.
absl::Status write_png(const std::string& path, const Image& image);

/// The bytes of such a file. INVALID_ARGUMENT if the image is empty, UNAVAILABLE if libpng fails.
absl::StatusOr<std::string> encode_png(const Image& image);

}  // namespace segserve::picture
