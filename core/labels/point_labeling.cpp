// SPDX-License-Identifier: Apache-2.0
#include "core/labels/point_labeling.hpp"

#include <utility>

#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {

absl::Status PointLabeling::run(const FrameContext& frame, const Supervoxels& supervoxels,
                                const std::vector<ReassignedPoint>& reassigned, const Cut& cut, VoxelGrid& grid,
                                std::vector<std::uint32_t>& supervoxel_of_point,
                                std::vector<std::uint32_t>& segment_of_point) {
  label_of_slot_.assign(grid.voxel_of_slot.size(), PointLabel{});
  StopCheck check(frame.stop);
  check.for_each(1, label_of_slot_.size(), [&](std::size_t slot) {
    const std::uint32_t voxel = grid.voxel_of_slot[slot];
    if (voxel == kNoVoxel) return;
    const std::uint32_t s = supervoxels.supervoxel_of_voxel[voxel];
    label_of_slot_[slot] = {cut.segment_of_leaf[s], s + 1};
  });
  RETURN_IF_ERROR(check.status());

  // A single pass over the points sets both results: it overwrites each slot by the supervoxel.
  supervoxel_of_point = std::move(grid.slot_of_point);
  const std::size_t points = supervoxel_of_point.size();
  segment_of_point.resize(points);
  RETURN_IF_ERROR(parallel_parts(frame.executor, frame.stop, points,
                                 [&](unsigned, std::size_t begin, std::size_t end, StopCheck& part_check) {
                                   part_check.for_each_block(begin, end, [&](std::size_t first, std::size_t last) {
                                     const PointLabel* label_of_slot = label_of_slot_.data();
                                     std::uint32_t* segment = segment_of_point.data();
                                     std::uint32_t* supervoxel = supervoxel_of_point.data();
                                     for (std::size_t i = first; i < last; ++i) {
                                       const PointLabel label = label_of_slot[supervoxel[i]];
                                       segment[i] = label.segment;
                                       supervoxel[i] = label.supervoxel;
                                     }
                                   });
                                 }));
  check.for_each(0, reassigned.size(), [&](std::size_t i) {
    const auto [point, s] = reassigned[i];
    segment_of_point[point] = cut.segment_of_leaf[s];
    supervoxel_of_point[point] = s + 1;
  });
  return check.status();
}

}  // namespace segserve
