#pragma once

#include <cstdint>
#include <vector>

#include "segserve/voxel/voxel_key.hpp"

namespace segserve {

/// Voxels as `refine_normals` wants them: a column for each number, so that what is contiguous in a row of cells is one
/// load. All have room for kRefitPadding more voxels.
struct RefitScratch {
  std::vector<double> x, y, z;           ///< V: centroids
  std::vector<float> nx, ny, nz;         ///< V: first normals
  std::vector<std::int32_t> cell_x;      ///< V
  std::vector<VoxelKey> key;             ///< V; behind them, keys above all others
  std::vector<VoxelKey> row;             ///< R: y and z of the rows of cells with voxels, ascending
  std::vector<std::uint32_t> row_begin;  ///< R + 1: the first voxel of each row
};

}  // namespace segserve
