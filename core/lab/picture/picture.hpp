#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "segserve/cloud.hpp"

namespace segserve::picture {

struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgb;  ///< R, G, B of each pixel, rows from the top: 3 * width * height
};

struct RenderOptions {
  /// Size of the picture of an unorganised cloud, pixels. An organised one has its own size.
  std::uint32_t width = 960;
  std::uint32_t height = 720;
  /// Share of the segment's colour, 0 to 1; the rest is the point's own.
  float blend = 0.7F;
  /// Thin dark lines between segments; organised clouds only.
  bool borders = true;
  /// 0x00RRGGBB, where there is no point.
  std::uint32_t background = 0x18181B;
};

/// A picture of the cloud. `labels` has one entry per point: each segment gets its segment_color;
/// empty: the points' own colours (light grey, shaded by depth, if it has none).
///
/// An organised cloud is shown as its image, row by row. Others are projected point by point with
/// a z-buffer: from the sensor for CAMERA; for WORLD obliquely from above, on the sensor's
/// side if there is one (+z is up).
Image render(const CloudView& cloud, std::span<const std::uint32_t> labels, const RenderOptions& options = {});

/// A stable colour for a label, 0x00RRGGBB; neighbouring labels look different. 0 (no point) is dark grey.
std::uint32_t segment_color(std::uint32_t label);

/// Writes an 8-bit RGB PNG; "-" is standard output. INVALID_ARGUMENT if the image is empty,
/// PERMISSION_DENIED or NOT_FOUND if the file cannot be opened, UNAVAILABLE if writing fails.
absl::Status write_png(const std::string& path, const Image& image);

}  // namespace segserve::picture
