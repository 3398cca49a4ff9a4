// SPDX-License-Identifier: Apache-2.0
#include "core/border_points/point_reassignment.hpp"

#include <algorithm>
#include <limits>

#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

constexpr double kReach = 2;         // edges of a voxel; voxels within it count as surroundings of a point
constexpr double kSurroundings = 2;  // their weight
constexpr double kMargin = 0.2;      // by which another supervoxel must fit better

/// Judges the points in voxels at borders.
class PointJudge {
 public:
  PointJudge(const FrameContext& frame, const VoxelGrid& grid, const std::vector<Vec3>& positions,
             const VoxelAdjacency& adjacency, const Supervoxels& supervoxels, const BorderVoxels& border,
             const std::vector<SupervoxelSurface>& surfaces)
      : scale_(frame.scale),
        grid_(grid),
        positions_(positions),
        adjacency_(adjacency),
        supervoxel_of_voxel_(supervoxels.supervoxel_of_voxel),
        border_(border),
        surfaces_(surfaces) {}

  /// The supervoxel of a point in voxel v.
  std::uint32_t supervoxel_of(const Vec3& point, std::uint32_t v) const {
    const std::uint32_t own = supervoxel_of_voxel_[v];
    const double edge = border_voxel_edge(scale_, point);
    double smallest = std::numeric_limits<double>::infinity();
    std::uint32_t fitting = own;
    for (const std::uint32_t s : border_.opposite_of(v)) {
      if (!surfaces_[s].is_defined()) continue;
      const double misfit = surfaces_[s].misfit(point, edge);
      if (misfit < smallest) smallest = misfit, fitting = s;
    }
    const double gain = surfaces_[own].misfit(point, edge) - smallest;
    if (!(gain + kSurroundings > kMargin)) return own;  // whatever the surroundings say
    return gain + kSurroundings * share_across(point, v) > kMargin ? fitting : own;
  }

 private:
  /// (T - S) / (T + S): -1 if all that is around the point is on the side of voxel v, and 1 if all is across the
  /// border.
  double share_across(const Vec3& point, std::uint32_t v) const {
    const Vec3 place = scale_.in_proportion ? to_voxel_space(scale_, point) : point;
    const auto opposite = border_.opposite_of(v);
    const double inverse_square_reach = 1 / (kReach * kReach * scale_.voxel * scale_.voxel);
    double all = 0, across = 0;
    const auto add = [&](std::uint32_t u) {
      const Vec3 d = positions_[u] - place;
      const double weight = std::max(0.0, 1 - dot(d, d) * inverse_square_reach) * grid_.points[u];
      all += weight;
      if (std::ranges::find(opposite, supervoxel_of_voxel_[u]) != opposite.end()) across += weight;
    };
    add(v);
    for (const std::uint32_t u : adjacency_.of(v)) add(u);
    return all > 0 ? 2 * across / all - 1 : 0;
  }

  const VoxelScale& scale_;
  const VoxelGrid& grid_;
  const std::vector<Vec3>& positions_;
  const VoxelAdjacency& adjacency_;
  const std::vector<std::uint32_t>& supervoxel_of_voxel_;
  const BorderVoxels& border_;
  const std::vector<SupervoxelSurface>& surfaces_;
};

/// Keeps the slots of the voxels whose points may be reassigned: those at a border in a supervoxel that has voxels
/// elsewhere, too, and a plane.
void find_slots(const VoxelGrid& grid, const Supervoxels& supervoxels, const BorderVoxels& border,
                const std::vector<SupervoxelSurface>& surfaces, StopCheck& check,
                std::vector<std::uint32_t>& voxel_of_slot) {
  std::vector<std::uint8_t> gives(supervoxels.count);
  check.for_each(0, grid.size(), [&](std::size_t v) {
    const std::uint32_t s = supervoxels.supervoxel_of_voxel[v];
    if (border.opposite_of(v).empty() && surfaces[s].is_defined()) gives[s] = 1;
  });
  voxel_of_slot.assign(grid.voxel_of_slot.size(), kNoVoxel);
  check.for_each(1, voxel_of_slot.size(), [&](std::size_t slot) {
    const std::uint32_t v = grid.voxel_of_slot[slot];
    if (v == kNoVoxel || border.opposite_of(v).empty()) return;
    if (gives[supervoxels.supervoxel_of_voxel[v]] != 0) voxel_of_slot[slot] = v;
  });
}

void move_point(const CloudView& cloud, const ReassignedPoint& moved, std::uint32_t from, RegionGraph& graph) {
  Region &source = graph.regions[from], &target = graph.regions[moved.supervoxel];
  --source.points;
  ++target.points;
  if (!cloud.has_color()) return;
  const std::uint32_t rgb = cloud.rgb[moved.point];
  const Vec3 color{static_cast<double>(red(rgb)), static_cast<double>(green(rgb)), static_cast<double>(blue(rgb))};
  source.color_sum -= color;
  target.color_sum += color;
}

}  // namespace

absl::Status PointReassignment::run(const FrameContext& frame, const VoxelGrid& grid,
                                    const std::vector<Vec3>& positions, const VoxelAdjacency& adjacency,
                                    const Supervoxels& supervoxels, const std::vector<BorderEvidence>& evidence,
                                    RegionGraph& graph, std::vector<ReassignedPoint>& reassigned) {
  reassigned.clear();
  RETURN_IF_ERROR(find_border_voxels(frame, supervoxels, graph, evidence, border_));
  if (border_.opposite.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(find_surfaces(frame, graph, surfaces_));
  StopCheck check(frame.stop);
  find_slots(grid, supervoxels, border_, surfaces_, check, voxel_of_slot_);
  RETURN_IF_ERROR(check.status());

  const PointJudge judge(frame, grid, positions, adjacency, supervoxels, border_, surfaces_);
  const CloudView& cloud = frame.cloud;
  parts_.resize(frame.executor.threads());
  RETURN_IF_ERROR(
      parallel_parts(frame.executor, frame.stop, cloud.size(),
                     [&](unsigned part, std::size_t begin, std::size_t end, StopCheck& part_check) {
                       parts_[part].clear();
                       part_check.for_each(begin, end, [&](std::size_t i) -> std::uint64_t {
                         const std::uint32_t v = voxel_of_slot_[grid.slot_of_point[i]];
                         if (v == kNoVoxel) return 1;
                         const std::uint32_t s = judge.supervoxel_of({cloud.x[i], cloud.y[i], cloud.z[i]}, v);
                         if (s != supervoxels.supervoxel_of_voxel[v])
                           parts_[part].push_back({static_cast<std::uint32_t>(i), s});
                         return 1 + adjacency.of(v).size();
                       });
                     }));
  for (const auto& part : parts_) reassigned.insert(reassigned.end(), part.begin(), part.end());
  check.for_each(0, reassigned.size(), [&](std::size_t i) {
    const std::uint32_t v = voxel_of_slot_[grid.slot_of_point[reassigned[i].point]];
    move_point(cloud, reassigned[i], supervoxels.supervoxel_of_voxel[v], graph);
  });
  return check.status();
}

}  // namespace segserve
