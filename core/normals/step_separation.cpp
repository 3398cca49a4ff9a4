// SPDX-License-Identifier: Apache-2.0
#include "core/normals/step_separation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/stop_check.hpp"

namespace segserve {

absl::Status separate_steps(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                            VoxelAdjacency& adjacency) {
  if (!frame.scale.sweep) return absl::OkStatus();
  constexpr double kNear = 1.5, kOnPlane = 0.5;     // heights of a voxel
  constexpr double kLeast = 0.15, kFarthest = 0.5;  // meters
  StopCheck check(frame.stop);
  std::vector<double> height(grid.size());
  check.for_each(0, grid.size(), [&](std::size_t v) {
    height[v] = frame.scale.sweep->elevation_ratio * voxel_edge(frame.scale, frame.view(), grid.centroid[v]);
  });
  const auto is_on_plane = [&](const Vec3& offset, const Vec3& normal, double most) {
    return normal != Vec3{} && std::fabs(dot(offset, normal)) <= most;
  };
  std::size_t kept = 0;
  std::uint32_t begin = 0;  // of the neighbors of v before any were left out
  check.for_each(0, grid.size(), [&](std::size_t v) {
    const std::uint32_t end = adjacency.offset[v + 1];
    const std::uint32_t degree = end - begin;
    for (; begin < end; ++begin) {
      const std::uint32_t u = adjacency.neighbor[begin];
      const Vec3 offset = grid.centroid[u] - grid.centroid[v];
      const double mean = 0.5 * (height[u] + height[v]), most = std::max(kLeast, kOnPlane * mean);
      const double near = std::min(kNear * mean, kFarthest);
      const bool is_near = dot(offset, offset) <= near * near;
      if (is_near || is_on_plane(offset, normals[u], most) || is_on_plane(offset, normals[v], most)) {
        adjacency.neighbor[kept++] = u;
      }
    }
    adjacency.offset[v + 1] = static_cast<std::uint32_t>(kept);
    return degree + std::uint64_t{1};
  });
  if (!check.stopped()) adjacency.neighbor.resize(kept);
  return check.status();
}

}  // namespace segserve
