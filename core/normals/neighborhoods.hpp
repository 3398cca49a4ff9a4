#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/normals/simd/normal_kernels.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// How far the window around a voxel reaches in each of the three directions, cells.
inline constexpr std::int32_t kWindowReach = 2;

/// For each voxel all voxels in the window around it, itself included, as the kernels want them that fit planes to
/// windows: voxels by columns, a column for each number, so that what is contiguous in a row of cells is one load.
/// Columns have room for kWindowPadding more voxels.
struct VoxelWindows {
  std::vector<double> x, y, z;             ///< V: centroids
  std::vector<float> nx, ny, nz;           ///< V: normals, left to those who fit them
  std::vector<float> inverse_square_edge;  ///< V: 1 / voxel_edge^2
  std::vector<std::int32_t> cell_x;        ///< V
  std::vector<VoxelKey> row;               ///< R: y and z of the rows of cells with voxels, ascending
  std::vector<std::uint32_t> row_begin;    ///< R + 1: the first voxel of each row

  /// What one thread found. All voxels are in one group each, whatever the number of threads.
  struct Part {
    std::vector<WindowGroup> groups;
    std::vector<RowSpan> spans;  ///< of the groups; there may be more
  };
  std::vector<Part> parts;

  WindowColumns columns() const {
    return {x.data(), y.data(), z.data(), nx.data(), ny.data(), nz.data(), inverse_square_edge.data(), cell_x.data()};
  }
};

/// O(V). CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_windows(const VoxelGrid& grid, const View& view, double voxel_resolution, unsigned threads,
                          const StopToken& stop, VoxelWindows& windows);

}  // namespace segserve
