// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/base/radix_sort.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Voxels from which supervoxels grow.
struct Seeds {
  std::vector<std::uint32_t> chosen;  ///< a voxel of each occupied cell with enough surface around it, by cell
  std::vector<std::uint32_t> sparse;  ///< a voxel of each other occupied cell, for what the chosen seeds do not reach
};

/// A cell of the cubic grid whose edge is the seed resolution.
struct SeedCell {
  std::int32_t x, y, z;
  bool operator==(const SeedCell&) const = default;
};

/// Selects seeds as in VCCS: in each occupied cell of a cubic grid of edge `seed_resolution` (meters, fixed origin) the
/// voxel nearest to the center of the cell. As in PCL, a seed is chosen if more voxels lie within half a seed
/// resolution of it than a twentieth of a flat disc has. There are two differences from PCL. A seed never lies outside
/// its cell, so that no voxel is a seed twice. And the size of a voxel is its true one, voxel_resolution z in a CAMERA
/// view, so that far surfaces get seeds, too.
class SeedSelection {
 public:
  /// CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const std::vector<Vec3>& positions, Seeds& seeds);

  /// Buffers of the sort of voxels by cell. Consecutive voxels in one cell are a run, which is sorted as a whole.
  struct Scratch {
    std::vector<std::uint32_t> run_begin;  ///< the first voxel of each run, and the number of voxels
    std::vector<SeedCell> cell_of_run;
    std::vector<std::uint64_t> key_of_run;
    std::vector<std::uint32_t> order;       ///< of the runs, by key
    std::vector<std::uint64_t> cell_key;    ///< of the occupied cells, ascending
    std::vector<std::uint32_t> cell_begin;  ///< where the runs of each cell begin in `order`, and the number of runs
    math::SortScratch sort;
  };

 private:
  Scratch scratch_;
};

}  // namespace segserve
