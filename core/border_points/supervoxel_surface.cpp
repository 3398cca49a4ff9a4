// SPDX-License-Identifier: Apache-2.0
#include "core/border_points/supervoxel_surface.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

/// The root mean square distance of the voxels of a region from its plane, meters.
double roughness(const Region& region, const Vec3& n) {
  const Symmetric3& s = region.scatter;
  const double sum = n.x * n.x * s.xx + n.y * n.y * s.yy + n.z * n.z * s.zz +
                     2 * (n.x * n.y * s.xy + n.x * n.z * s.xz + n.y * n.z * s.yz);
  return std::sqrt(std::max(0.0, sum) / region.voxels);
}

}  // namespace

absl::Status find_surfaces(const FrameContext& frame, const RegionGraph& graph,
                           std::vector<SupervoxelSurface>& surfaces) {
  constexpr double kSmallestRoughness = 0.1;  // edges of a voxel
  StopCheck check(frame.stop);
  surfaces.resize(graph.regions.size());
  check.for_each(0, surfaces.size(), [&](std::size_t s) {
    const Region& region = graph.regions[s];
    const Vec3 normal = unit(region.normal_sum);
    const double rough = roughness(region, normal) / border_voxel_edge(frame.scale, region.centroid);
    surfaces[s] = {region.centroid, normal, 1 / (rough + kSmallestRoughness)};
  });
  return check.status();
}

}  // namespace segserve
