// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"

namespace segserve::picture {

class SegmentColors;

struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgb;  ///< R, G, B of each pixel, rows from the top: 3 * width * height
};

struct RenderOptions {
  /// Size of the picture of an unorganized cloud in pixels, without the legend. The picture of an organized cloud has
  /// the size of the cloud unless `view_from` is set.
  std::uint32_t width = 960;
  std::uint32_t height = 720;
  /// Share of the segment's color, 0 to 1. The rest is the point's own color.
  float blend = 0.7F;
  /// Whether thin dark lines separate segments; only in the image of an organized cloud.
  bool borders = true;
  /// Whether numbers of labels stand on the largest segments, and a legend with labels and sizes at the right.
  bool legend = false;
  /// From where the cloud is seen, in its frame; the middle of the cloud is in the middle of the picture. Unset: see
  /// render().
  std::optional<Eigen::Vector3f> view_from = std::nullopt;
  /// The colors of the pictures before, which this one goes on with. Null: it has colors of its own.
  SegmentColors* colors = nullptr;
  /// The color, 0x00RRGGBB, where there is no point.
  std::uint32_t background = 0x18181B;
};

/// A picture of the cloud. `labels` has one entry per point. Segments that touch in the picture never look alike: see
/// SegmentColors. If `labels` is empty, points have their own colors, or light gray shaded by depth if the cloud has no
/// color.
///
/// An organized cloud is shown as its image, row by row. Other clouds are projected point by point with a z-buffer, and
/// small holes in surfaces are closed. A CAMERA cloud is seen from the sensor. So is a WORLD cloud if the sensor sees
/// nearly all of it at once; else it is seen obliquely from above (+z is up), from the side of the sensor if there is
/// one.
Image render(const CloudView& cloud, std::span<const std::uint32_t> labels, const RenderOptions& options = {});

/// The colors that segments have in the picture that `render` makes of these.
SegmentColors colors_in_picture(const CloudView& cloud, std::span<const std::uint32_t> labels,
                                const RenderOptions& options = {});

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
