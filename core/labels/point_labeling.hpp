// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/border_points/point_reassignment.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "segserve/merge_tree.hpp"

namespace segserve {

/// Labels the points of the cloud. Keeps its buffers between frames.
class PointLabeling {
 public:
  /// Sets the supervoxel (1..m) and the segment (1..cut.segments) of every point (N); both are 0 for points that are
  /// not segmented. `supervoxels` must be those of the grid, `reassigned` points that belong to others than their
  /// voxels do, and `cut` one of the merge tree. Takes the memory of grid.slot_of_point for the result, which is four
  /// bytes less for each point. O(N + V).
  /// CANCELLED, DEADLINE_EXCEEDED.
  absl::Status run(const FrameContext& frame, const Supervoxels& supervoxels,
                   const std::vector<ReassignedPoint>& reassigned, const Cut& cut, VoxelGrid& grid,
                   std::vector<std::uint32_t>& supervoxel_of_point, std::vector<std::uint32_t>& segment_of_point);

 private:
  struct PointLabel {
    std::uint32_t segment = 0, supervoxel = 0;
  };

  std::vector<PointLabel> label_of_slot_;
};

}  // namespace segserve
