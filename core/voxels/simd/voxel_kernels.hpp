#pragma once

#include <cstddef>
#include <cstdint>

namespace segserve {

/// Limits of a Selection; all of them are closed.
struct SelectionLimits {
  float low[3], high[3];
  float sensor[3];
  float nearest_squared, farthest_squared;
};

/// Points, and how they become cells (CellMapping).
struct CellInput {
  const float *x, *y, *z;
  bool camera;
  float cells_per_metre, units_per_metre;
  const SelectionLimits* selection;  ///< null: all
};

/// A key (kNoKey: not finite, or not selected) and fixed-point coordinates for each point; room for 7 more points.
struct CellOutput {
  std::uint64_t* keys;
  std::int32_t *x, *y, *z;
};

/// Sums over points: exact. The three colours share a word, enough for kMost points.
struct alignas(32) PointSums {
  static constexpr int kColorBits = 21;
  static constexpr std::size_t kMost = std::size_t{1} << (kColorBits - 8);
  std::int64_t x, y, z;
  std::uint64_t color;  ///< red, green, blue, from the highest bits to the lowest
};

/// What find_cells found, and the points' colours.
struct RunInput {
  const std::uint64_t* keys;
  const std::int32_t *x, *y, *z;
  const std::uint32_t* rgb;  ///< null: none
};

/// Run r, from 0 on, are the points [ends[r], ends[r + 1]), with the sums sums[r + 1] - sums[r].
struct RunOutput {
  std::uint32_t* ends;
  PointSums* sums;
};

/// The inner loops of voxelization, compiled once for each kind of CPU. All give the same bytes.
struct VoxelKernels {
  /// The cells of `count` points. Returns the first point that is selected, finite and has no cell; else `count`.
  std::size_t (*find_cells)(const CellInput& in, std::size_t count, const CellOutput& out);
  /// Divides `count` points, PointSums::kMost at most, into runs of equal keys. Returns their number.
  std::size_t (*find_runs)(const RunInput& in, std::size_t count, const RunOutput& out);
};

/// Those for `cpu_in_use`.
const VoxelKernels& voxel_kernels();

}  // namespace segserve
