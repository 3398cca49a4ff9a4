#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace segserve::eval {

/// How many pixels a boundary of a supervoxel may be off.
inline constexpr std::uint32_t kBoundaryTolerance = 2;

/// Boundary recall: the share of the ground truth's boundary pixels that have a boundary pixel of the supervoxels
/// within kBoundaryTolerance rows and columns (a window of 5 x 5). A pixel is on a labelling's boundary if it and one
/// of its four neighbours both have ground truth (not 0) and differ in that labelling; so the edge of a hole is no
/// boundary. One entry a pixel in both, row by row. Nothing if the cloud is no image (height 1) or has no such
/// boundary.
std::optional<double> boundary_recall(std::span<const std::uint32_t> truth, std::span<const std::uint32_t> supervoxels,
                                      std::uint32_t width, std::uint32_t height);

}  // namespace segserve::eval
