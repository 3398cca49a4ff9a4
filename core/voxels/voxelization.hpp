// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/base/radix_sort.hpp"
#include "core/voxels/range_voxelizer.hpp"
#include "core/voxels/voxel_admission.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// Sorts the finite points of a cloud that the options select into voxels of edge `voxel_resolution`. Keeps its buffers
/// between frames.
class Voxelization {
 public:
  /// The edge is in meters; in a CAMERA view the cells are cubes of (x/z, y/z, ln z), so the edge is
  /// voxel_resolution * z. O(N + V).
  /// INVALID_ARGUMENT, naming the first such point of the selection: z <= 0 in a CAMERA view, or a coordinate beyond
  /// the grid (about 2^18 voxels from the origin). CANCELLED, DEADLINE_EXCEEDED, and the refusal of `admission`, which
  /// is not asked if it is null.
  absl::Status run(const FrameContext& frame, VoxelGrid& grid, VoxelAdmission* admission = nullptr);

  /// Gives back the hash tables of a cloud of scattered points, which take more memory than any other stage. The
  /// tables of other clouds are kept, because growing them again takes time.
  void free_scattered_tables();

 private:
  absl::Status merge_parts(const FrameContext& frame, VoxelGrid& grid);
  absl::Status sort_voxels(const FrameContext& frame, double coordinate_unit, VoxelGrid& grid);

  std::vector<PartialVoxels> parts_;   // one for each thread
  std::vector<std::uint64_t> ranked_;  // V: keys without the bits that all of them share
  std::vector<std::uint32_t> order_;   // V
  math::SortScratch sort_;
};

}  // namespace segserve
