// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/lab/picture/raster.hpp"

namespace segserve::picture {

/// The colors of segments in pictures. Segments that touch in a picture never look alike, and a label keeps its color
/// from picture to picture as long as that holds.
class SegmentColors {
 public:
  using LabelPair = std::pair<std::uint32_t, std::uint32_t>;

  /// Gives colors to labels. Those that have one already choose first, and then the others in this order, so that the
  /// largest should be first. A label gets segment_color(label) unless a neighbor looks like that.
  void update(std::span<const std::uint32_t> labels, std::span<const LabelPair> neighbors);

  /// The color of a label, 0x00RRGGBB; segment_color of one that has none yet.
  std::uint32_t operator()(std::uint32_t label) const;

 private:
  std::map<std::uint32_t, std::uint32_t> color_;
  std::uint32_t spare_ = 0;  // segment_color of greater labels belongs to nobody
};

/// How different two colors, 0x00RRGGBB, look: their distance in Oklab (B. Ottosson, 2020). Black and white differ
/// by 1.
double color_difference(std::uint32_t a, std::uint32_t b);

/// Neighbors whose colors differ less look alike.
inline constexpr double kLeastColorDifference = 0.12;

/// The labels that are seen in a picture, except 0: the largest first, counted in pixels.
std::vector<std::uint32_t> labels_by_size(const Raster& raster, std::span<const std::uint32_t> labels);

/// The pairs of labels, except 0, that are seen at most two pixels apart, each once and the smaller label first.
std::vector<SegmentColors::LabelPair> label_neighbors(const Raster& raster, std::span<const std::uint32_t> labels);

}  // namespace segserve::picture
