// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/normals/simd/normal_kernels.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// How far a neighborhood reaches from its voxel in each of the three directions, cells: it is 5 x 5 x 5 cells large.
inline constexpr std::int32_t kNeighborhoodReach = 2;

/// The neighborhood of each voxel: all voxels in the 5 x 5 x 5 cells around it, itself included. The layout is that of
/// the kernels that fit planes to neighborhoods. Each property of the voxels is a column, so that the voxels side by
/// side in a row of cells are one load. Columns have room for kColumnPadding more voxels.
struct Neighborhoods {
  std::vector<double> x, y, z;             ///< V: centroids
  std::vector<float> nx, ny, nz;           ///< V: normals; find_neighborhoods only makes room for them
  std::vector<float> inverse_square_edge;  ///< V: 1 / voxel_edge^2
  std::vector<std::int32_t> cell_x;        ///< V
  std::vector<VoxelKey> row;               ///< R: y and z of the rows of cells with voxels, ascending
  std::vector<std::uint32_t> row_begin;    ///< R + 1: the first voxel of each row

  /// The groups that one thread found. Every voxel is in one group of one part. Groups do not depend on the number of
  /// threads.
  struct Part {
    std::vector<VoxelGroup> groups;
    std::vector<RowSpan> spans;  ///< to which the groups refer; there may be more
  };
  std::vector<Part> parts;

  VoxelColumns columns() const {
    return {x.data(), y.data(), z.data(), nx.data(), ny.data(), nz.data(), inverse_square_edge.data(), cell_x.data()};
  }
};

/// O(V). CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_neighborhoods(const FrameContext& frame, const VoxelGrid& grid, Neighborhoods& neighborhoods);

}  // namespace segserve
