// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/point_selection.hpp"
#include "core/voxels/point_selections.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"
#include "core/voxels/voxel_admission.hpp"
#include "core/voxels/voxel_table.hpp"
#include "segserve/cloud.hpp"

namespace segserve {

/// The voxels of a part of the cloud, as one thread gathers them.
struct PartialVoxels {
  VoxelTable table;
  PointsWithoutCell without_cell;  ///< indices are those of the cloud
  std::size_t finite_points = 0;   ///< does not count zeros in a CAMERA view
};

/// Voxelizes a contiguous range of points, in chunks that stay in the first cache. Writes the slots of the points in
/// the table of `part` to `slot_of_point`, which grows as far as it has to; if several threads do this at the same
/// time, it must have room for all points from the start.
class RangeVoxelizer {
 public:
  RangeVoxelizer(const CloudView& cloud, const PointSelections& selections, const CellMapping& mapping,
                 PartialVoxels& part, std::vector<std::uint32_t>& slot_of_point)
      : cloud_(cloud), selections_(selections), mapping_(mapping), part_(part), slot_of_point_(slot_of_point) {}

  /// Stops before the end if the admission, which may be null, refuses the frame.
  void run(std::size_t begin, std::size_t end, StopCheck& check, VoxelAdmission* admission);

 private:
  static constexpr std::size_t kChunk = 512;
  static_assert(kChunk <= PointSums::kMost);
  static constexpr std::size_t kRoom = 8;  // beyond the end of a chunk, for loops that write eight entries at a time

  template <typename T>
  using PerPoint = std::array<T, kChunk + kRoom>;

  void find_cells(const PointSelection& selection, std::size_t first, std::size_t count);
  void count_finite(std::size_t first, std::size_t count);
  std::size_t find_runs(std::size_t first, std::size_t count);
  void find_slots(std::size_t runs);

  const CloudView& cloud_;
  const PointSelections& selections_;
  const CellMapping& mapping_;
  PartialVoxels& part_;
  std::vector<std::uint32_t>& slot_of_point_;
  const VoxelKernels& kernels_ = voxel_kernels();

  PerPoint<VoxelKey> keys_;
  PerPoint<std::int32_t> x_, y_, z_;  // fixed point
  PerPoint<PointSums> sums_;          // over the points before each run
  PerPoint<std::uint32_t*> cells_;    // where the table keeps the slot of each run
  PerPoint<std::uint32_t> run_begin_, hash_, slot_of_run_, slots_;
};

}  // namespace segserve
