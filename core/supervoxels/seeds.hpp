#pragma once

#include <cstdint>
#include <vector>

#include "core/base/radix_sort.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// Voxels from which supervoxels grow.
struct Seeds {
  std::vector<std::uint32_t> chosen;  ///< one voxel for each occupied cell that has enough surface, in cell order
  std::vector<std::uint32_t> sparse;  ///< those of the cells left out: used only where nothing else reaches
};

/// Buffers of `select_seeds` that are worth keeping between calls.
struct SeedScratch {
  struct Cell {
    std::int32_t x, y, z;
    bool operator==(const Cell&) const = default;
  };
  std::vector<std::uint32_t> run;  ///< the first voxels of runs of voxels in the same cell
  std::vector<Cell> cell_of_run;
  std::vector<std::uint64_t> keys, cells;
  std::vector<std::uint32_t> order, begin;
  math::SortScratch sort;
};

/// VCCS: in each occupied cell of a cubic grid of edge `seed_resolution` (metres, fixed origin), the
/// voxel nearest to the cell's centre. As in PCL, a seed counts if the voxels within half a seed
/// resolution are more than a twentieth of a flat disc; other than there, a seed never lies outside
/// its cell, so no voxel is a seed twice, and the size of a voxel is its true one (in a CAMERA view
/// voxel_resolution * z), so that far surfaces get seeds, too. If stopped, the seeds are useless.
void select_seeds(const VoxelGrid& grid, const View& view, double voxel_resolution, double seed_resolution,
                  SeedScratch& scratch, Seeds& seeds, const StopToken& stop = {});

}  // namespace segserve
