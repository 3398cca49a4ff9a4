#include "segserve/graph/border.hpp"

#include <algorithm>
#include <cmath>

#include "segserve/math/elementary.hpp"

namespace segserve {
namespace {

/// The angle by which a pair of voxels is concave.
class Concavity {
 public:
  explicit Concavity(double dead_zone) : dead_zone_(dead_zone) {
    const double tangent = math::sin(dead_zone * math::kDegree) / math::cos(dead_zone * math::kDegree);
    if (dead_zone < 90) flat_ = kClear * tangent * tangent;
  }

  /// Angle of the normals beyond the dead zone in degrees where the pair is concave, else 0.
  double operator()(const Vec3& xa, const Vec3& na, const Vec3& xb, const Vec3& nb) const {
    if (dot(na - nb, xa - xb) >= 0 || na == Vec3{} || nb == Vec3{}) return 0;
    const Vec3 across = cross(na, nb);
    const double sine2 = dot(across, across), cosine = dot(na, nb);
    // Within the dead zone by its tangent: spares four of five arctangents.
    if (cosine > 0 && sine2 < flat_ * (cosine * cosine)) return 0;
    return std::max(0.0, math::atan2(std::sqrt(sine2), cosine) / math::kDegree - dead_zone_);
  }

 private:
  static constexpr double kClear = 1 - 1e-9;  // far beyond rounding errors

  double dead_zone_;
  double flat_ = 0;  // the square of the tangent
};

}  // namespace

std::vector<Border> measure_borders(const RegionGraph& graph, const VoxelGrid& grid, const VoxelAdjacency& adjacency,
                                    const std::vector<Vec3>& normals, const Supervoxels& supervoxels, double dead_zone,
                                    const StopToken& stop) {
  StopCheck check(stop);
  // Edges with the same smaller region stand together: (a, b) is found by a search among those of a.
  std::vector<std::size_t> first_edge(graph.regions.size() + 1, graph.edges.size());
  for (std::size_t e = graph.edges.size(); e-- > 0 && !check.after(1);) first_edge[graph.edges[e].a] = e;
  for (std::size_t r = graph.regions.size(); r-- > 0 && !check.after(1);) {
    first_edge[r] = std::min(first_edge[r], first_edge[r + 1]);
  }
  std::vector<Border> borders(graph.edges.size());
  const Concavity concavity(dead_zone);
  const auto measure_from = [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    const std::uint32_t s = supervoxels.of_voxel[v];
    for (const std::uint32_t u : adjacency.of(v)) {
      const std::uint32_t t = supervoxels.of_voxel[u];
      if (u < v || s == t) continue;
      const auto [a, b] = std::minmax(s, t);
      const auto begin = graph.edges.begin() + static_cast<std::ptrdiff_t>(first_edge[a]);
      const auto end = graph.edges.begin() + static_cast<std::ptrdiff_t>(first_edge[a + 1]);
      const auto edge = std::lower_bound(begin, end, b, [](const RegionEdge& e, std::uint32_t id) { return e.b < id; });
      Border& border = borders[static_cast<std::size_t>(edge - graph.edges.begin())];
      border.voxel_pairs += 1;
      border.concavity += concavity(grid.centroid[v], normals[v], grid.centroid[u], normals[u]);
    }
    return 1 + adjacency.of(v).size();
  };
  check.for_each(0, grid.size(), measure_from);
  check.for_each(0, borders.size(), [&](std::size_t e) { borders[e].concavity /= borders[e].voxel_pairs; });
  return borders;
}

}  // namespace segserve
