// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace segserve::eval {

// Scores of the boundaries of a labeling against those of the ground truth, for organized clouds. Arrays have one entry
// per pixel, row by row: width * height. A pixel is on the boundary of a labeling if it and one of its four neighbors
// both have ground truth (not 0) and differ in that labeling. The edge of a hole is therefore no boundary.

/// The largest distance, in rows and in columns, at which a boundary pixel counts as found: a window of 5 x 5.
inline constexpr std::uint32_t kBoundaryTolerance = 2;

struct BoundaryScores {
  /// Share of the labeling's boundary pixels that have a boundary pixel of the ground truth within the tolerance. Unset
  /// if the labeling has no boundary.
  std::optional<double> precision;
  /// Share of the ground truth's boundary pixels that have a boundary pixel of the labeling within the tolerance.
  double recall = 0;
  double f = 0;  ///< Harmonic mean of both; 0 if the labeling has no boundary.
};

/// Unset if the cloud is not an image (height 1), or if the ground truth has no boundary.
std::optional<BoundaryScores> boundary_scores(std::span<const std::uint32_t> truth,
                                              std::span<const std::uint32_t> labels, std::uint32_t width,
                                              std::uint32_t height);

/// The recall alone, by which supervoxels are judged: they have many boundaries on purpose. Unset as boundary_scores.
std::optional<double> boundary_recall(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> supervoxels,
                                      std::uint32_t width, std::uint32_t height);

}  // namespace segserve::eval
