// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace segserve {

/// The limits of a PointSelection, all of them closed.
struct SelectionLimits {
  float low[3], high[3];
  float sensor[3];
  float nearest_squared, farthest_squared;
};

/// Points, and the constants by which they become cells (CellMapping).
struct CellInput {
  const float *x, *y, *z;
  bool camera;
  float cells_per_meter, units_per_meter;
  float elongation_depth, elongation_depth_logarithm;
  const SelectionLimits* selection;  ///< null selects all points
};

/// A key and fixed-point coordinates for each point. The key is kNoKey if the point is not finite, not selected, or has
/// no cell. There must be room for 7 more points.
struct CellOutput {
  std::uint64_t* keys;
  std::int32_t *x, *y, *z;
};

/// Selected finite points that have no cell. In a CAMERA view, (0, 0, 0) is how many programs write a pixel without
/// depth.
struct PointsWithoutCell {
  std::size_t zeros = 0;               ///< points at (0, 0, 0) in a CAMERA view
  std::size_t others = 0;              ///< points beyond the grid, or with z <= 0 in a CAMERA view
  std::size_t first_other = SIZE_MAX;  ///< index of the first of the others
};

/// Exact sums over points. The three color channels share a word, which is enough for kMost points.
struct alignas(32) PointSums {
  static constexpr int kColorBits = 21;
  static constexpr std::size_t kMost = std::size_t{1} << (kColorBits - 8);
  std::int64_t x, y, z;
  std::uint64_t color;  ///< red, green and blue, from the highest bits to the lowest
};

/// The output of find_cells, and the colors of the points.
struct RunInput {
  const std::uint64_t* keys;
  const std::int32_t *x, *y, *z;
  const std::uint32_t* rgb;  ///< null for a cloud without color
};

/// Run r, from 0 on, has the points [ends[r], ends[r + 1]), whose sums are sums[r + 1] - sums[r].
struct RunOutput {
  std::uint32_t* ends;
  PointSums* sums;
};

/// The inner loops of voxelization, compiled once for each SimdTarget. All versions give the same bytes.
struct VoxelKernels {
  /// Finds the cells of `count` points. Returns those that have none.
  PointsWithoutCell (*find_cells)(const CellInput& in, std::size_t count, const CellOutput& out);
  /// Divides `count` points, PointSums::kMost at most, into runs of equal keys. Returns their number.
  std::size_t (*find_runs)(const RunInput& in, std::size_t count, const RunOutput& out);
};

/// The kernels for `simd_target`.
const VoxelKernels& voxel_kernels();

}  // namespace segserve
