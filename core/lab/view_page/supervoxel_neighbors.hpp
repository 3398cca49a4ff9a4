// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::view_page {

/// Which supervoxels touch, and how dense the points are.
struct SupervoxelNeighbors {
  /// Pairs of leaves a < b, each once, in ascending order: supervoxels a + 1 and b + 1 have points in voxels that
  /// touch.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  /// The typical distance between neighboring points, meters. In a CAMERA view it is that at 1 m depth.
  double spacing = 0;
};

/// Finds the neighbors among the supervoxels of N points (0 is none) with voxels of an edge in meters. In a CAMERA view
/// the voxels grow with the depth, and this is their edge at 1 m. Points that are not finite count for nothing. Of a
/// voxel with points of more than 64 supervoxels, which is far too large for the cloud, only so many are looked at.
SupervoxelNeighbors supervoxel_neighbors(const CloudView& cloud, std::span<const std::uint32_t> supervoxels,
                                         double voxel);

}  // namespace segserve::view_page
