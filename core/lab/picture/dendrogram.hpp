// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/lab/picture/picture.hpp"
#include "core/lab/picture/segment_colors.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve::picture {

struct DendrogramOptions {
  std::uint32_t width = 1440;  ///< pixels, with the legend
  std::uint32_t height = 900;
  /// Where the tree was cut: at a threshold, or to a number of regions. A line shows it.
  std::optional<double> threshold = std::nullopt;
  std::optional<std::uint32_t> regions = std::nullopt;
  /// Only so many of the last merges are drawn one by one, and those between segments, but none that is too low to be
  /// seen. What lies below is one end of the tree.
  std::uint32_t merges = 200;
};

/// The merge tree as a drawing: supervoxels from left to right, and heights of merges from the bottom to the top, with
/// an axis. Branches within a segment have its color, also as a strip below, and merges of several segments are gray.
/// `segment_of_leaf` has the segment of each leaf, or 0 if it is not known. The picture of a tree without leaves says
/// so.
Image draw_dendrogram(const MergeTree& tree, std::span<const std::uint32_t> segment_of_leaf,
                      const SegmentColors& colors, const DendrogramOptions& options);

/// The segment of each of the m supervoxels, of which N points have these numbers (0 is none) and labels. 0 for
/// supervoxels without points.
std::vector<std::uint32_t> segments_of_leaves(std::size_t leaves, std::span<const std::uint32_t> supervoxels,
                                              std::span<const std::uint32_t> labels);

}  // namespace segserve::picture
