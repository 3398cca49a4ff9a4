// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace segserve::eval {

/// The largest distance, in rows and in columns, at which a boundary of a supervoxel counts as found.
inline constexpr std::uint32_t kBoundaryTolerance = 2;

/// Boundary recall: the share of the ground truth's boundary pixels that have a boundary pixel of the supervoxels
/// within kBoundaryTolerance rows and columns (a window of 5 x 5). A pixel is on the boundary of a labeling if it and
/// one of its four neighbors both have ground truth (not 0) and differ in that labeling. The edge of a hole is
/// therefore no boundary. Both arrays have one entry per pixel, row by row. Unset if the cloud is not an image (height
/// 1), or if the ground truth has no boundary.
std::optional<double> boundary_recall(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> supervoxels,
                                      std::uint32_t width, std::uint32_t height);

}  // namespace segserve::eval
