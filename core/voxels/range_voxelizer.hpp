#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/point_selection.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"
#include "core/voxels/voxel_table.hpp"
#include "segserve/cloud.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// What one thread gathers.
struct VoxelPart {
  VoxelTable table;
  std::size_t first_invalid = SIZE_MAX;
  std::size_t finite_points = 0;
};

/// Voxelises a contiguous range of points, in chunks that stay in the first cache. `slot_of_point` grows as far as it
/// has to; where several do this at the same time, it has the slots of all points from the start.
class RangeVoxelizer {
 public:
  RangeVoxelizer(const CloudView& cloud, const Selection& selection, const CellMapping& mapping, VoxelPart& part,
                 std::vector<std::uint32_t>& slot_of_point)
      : cloud_(cloud), selection_(selection), mapping_(mapping), part_(part), slot_of_point_(slot_of_point) {}

  void run(std::size_t begin, std::size_t end, StopCheck& check);

 private:
  static constexpr std::size_t kChunk = 512;
  static_assert(kChunk <= PointSums::kMost);
  static constexpr std::size_t kRoom = 8;  // beyond the end of a chunk, for those who write in eights

  template <typename T>
  using PerPoint = std::array<T, kChunk + kRoom>;

  bool find_cells(std::size_t first, std::size_t count);
  void count_finite(std::size_t first, std::size_t count);
  std::size_t find_runs(std::size_t first, std::size_t count);
  void find_slots(std::size_t runs);

  const CloudView& cloud_;
  const Selection& selection_;
  const CellMapping& mapping_;
  VoxelPart& part_;
  std::vector<std::uint32_t>& slot_of_point_;
  const VoxelKernels& kernels_ = voxel_kernels();

  PerPoint<VoxelKey> keys_;
  PerPoint<std::int32_t> x_, y_, z_;  // fixed point
  PerPoint<PointSums> sums_;          // of the points before each run
  PerPoint<std::uint32_t*> cells_;    // of the table, of each run
  PerPoint<std::uint32_t> run_begin_, hash_, slot_of_run_, slots_;
};

}  // namespace segserve
