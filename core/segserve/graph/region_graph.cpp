#include "segserve/graph/region_graph.hpp"

#include <algorithm>
#include <span>

namespace segserve {
namespace {

/// The voxels of each supervoxel, ascending: a counting sort.
class VoxelsBySupervoxel {
 public:
  VoxelsBySupervoxel(const Supervoxels& supervoxels, StopCheck& check)
      : begin_(supervoxels.count + std::size_t{1}, 0), voxels_(supervoxels.of_voxel.size()) {
    check.for_each(0, voxels_.size(), [&](std::size_t v) { ++begin_[supervoxels.of_voxel[v] + 1]; });
    check.for_each(0, supervoxels.count, [&](std::size_t s) { begin_[s + 1] += begin_[s]; });
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    check.for_each(0, voxels_.size(),
                   [&](std::size_t v) { voxels_[next[supervoxels.of_voxel[v]]++] = static_cast<std::uint32_t>(v); });
  }

  std::span<const std::uint32_t> of(std::uint32_t s) const {
    return std::span(voxels_).subspan(begin_[s], begin_[s + 1] - begin_[s]);
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> voxels_;
};

Region region_of(std::span<const std::uint32_t> voxels, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                 const View& view, double voxel_resolution, StopCheck& check) {
  Region region;
  check.for_each(0, voxels.size(), [&](std::size_t i) {
    const std::uint32_t v = voxels[i];
    region.voxels += 1;
    region.points += grid.points[v];
    const double edge = voxel_edge(voxel_resolution, view, grid.centroid[v]);
    region.area += edge * edge;
    region.centroid += grid.centroid[v];
    region.normal_sum += normals[v];
    region.color_sum += grid.color_sum[v];
  });
  region.centroid = (1 / region.voxels) * region.centroid;
  check.for_each(0, voxels.size(),
                 [&](std::size_t i) { region.scatter += outer(grid.centroid[voxels[i]] - region.centroid); });
  return region;
}

}  // namespace

void Region::merge(const Region& other) {
  const double total = voxels + other.voxels;
  const Vec3 between = other.centroid - centroid;
  scatter += other.scatter;
  scatter += (voxels * other.voxels / total) * outer(between);
  centroid += (other.voxels / total) * between;
  normal_sum += other.normal_sum;
  color_sum += other.color_sum;
  voxels = total;
  points += other.points;
  area += other.area;
}

RegionGraph build_region_graph(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                               const Supervoxels& supervoxels, const View& view, double voxel_resolution,
                               const StopToken& stop) {
  RegionGraph graph;
  StopCheck check(stop);
  const VoxelsBySupervoxel voxels(supervoxels, check);
  if (check.stopped()) return graph;
  graph.regions.reserve(supervoxels.count);
  std::vector<std::uint32_t> met(supervoxels.count, 0);  // the last supervoxel + 1 that met this one
  for (std::uint32_t a = 0; a < supervoxels.count; ++a) {
    graph.regions.push_back(region_of(voxels.of(a), grid, normals, view, voxel_resolution, check));
    const std::size_t first = graph.edges.size();
    const auto meet_neighbors = [&, of_a = voxels.of(a)](std::size_t i) {
      for (const std::uint32_t u : adjacency.of(of_a[i])) {
        const std::uint32_t b = supervoxels.of_voxel[u];
        if (b <= a || met[b] == a + 1) continue;
        met[b] = a + 1;
        graph.edges.push_back({a, b});
      }
      return 1 + adjacency.of(of_a[i]).size();
    };
    if (!check.for_each(0, voxels.of(a).size(), meet_neighbors)) return graph;
    std::sort(graph.edges.begin() + static_cast<std::ptrdiff_t>(first), graph.edges.end(),
              [](const RegionEdge& p, const RegionEdge& q) { return p.b < q.b; });
  }
  return graph;
}

}  // namespace segserve
