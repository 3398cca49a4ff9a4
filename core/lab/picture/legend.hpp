// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/lab/picture/canvas.hpp"
#include "core/lab/picture/picture.hpp"
#include "core/lab/picture/raster.hpp"
#include "core/lab/picture/segment_colors.hpp"

namespace segserve::picture {

/// A segment in a legend.
struct LegendEntry {
  std::uint32_t label = 0;
  std::uint32_t rgb = 0;
  std::size_t points = 0;
};

/// The segments of N points, the largest first. Label 0 is none.
std::vector<LegendEntry> legend_entries(std::span<const std::uint32_t> labels, const SegmentColors& colors);

/// The width in pixels that a legend of these entries needs.
int legend_width(std::span<const LegendEntry> entries);

/// How many entries have room in a legend of this height.
std::size_t legend_room(std::size_t entries, int height);

/// Draws how many segments there are, and color, label, points and share of the largest.
void draw_legend(std::span<const LegendEntry> entries, const Box& box, Canvas& canvas);

/// The picture with a legend at its right, and with the labels of its largest segments on them.
Image with_legend(const Image& picture, const Raster& raster, std::span<const std::uint32_t> labels,
                  const SegmentColors& colors);

inline constexpr std::uint32_t kPanelColor = 0x18181B;
inline constexpr std::uint32_t kTextColor = 0xE4E4E7;
inline constexpr std::uint32_t kFaintTextColor = 0xA1A1AA;

}  // namespace segserve::picture
