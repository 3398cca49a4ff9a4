// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/seeing_cameras.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/math/vec3.hpp"
#include "segserve/cloud.hpp"

namespace segserve {

absl::Status find_seeing_cameras(const FrameContext& frame, VoxelGrid& grid) {
  const std::vector<CameraPoints>& cameras = frame.view().cameras;
  grid.camera.clear();
  if (cameras.empty()) return absl::OkStatus();
  StopCheck check(frame.stop);
  std::vector<std::uint32_t> seen(grid.voxel_of_slot.size());  // points of one camera in each slot
  std::vector<std::uint32_t> most(grid.size());                // points of the best camera so far in each voxel
  std::vector<double> distance(grid.size());                   // from that camera
  grid.camera.resize(grid.size());
  std::size_t begin = 0;
  for (std::size_t c = 0; c < cameras.size() && !check.stopped(); ++c) {
    const std::size_t end = begin + cameras[c].points;
    check.for_each(begin, end, [&](std::size_t i) { ++seen[grid.slot_of_point[i]]; });
    begin = end;
    const Vec3 sensor = to_vec3(cameras[c].sensor.cast<double>());
    check.for_each(1, seen.size(), [&](std::size_t slot) {
      const std::uint32_t points = seen[slot], v = grid.voxel_of_slot[slot];
      seen[slot] = 0;
      if (points == 0 || v == kNoVoxel || points < most[v]) return;
      const double from_here = norm(grid.centroid[v] - sensor);
      if (points == most[v] && from_here >= distance[v]) return;
      most[v] = points;
      distance[v] = from_here;
      grid.camera[v] = static_cast<std::uint8_t>(c);
    });
  }
  return check.status();
}

}  // namespace segserve
