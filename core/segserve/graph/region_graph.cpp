#include "segserve/graph/region_graph.hpp"

#include <algorithm>
#include <numeric>
#include <span>

namespace segserve {
namespace {

/// The voxels of each supervoxel, ascending: a counting sort.
class VoxelsBySupervoxel {
 public:
  explicit VoxelsBySupervoxel(const Supervoxels& supervoxels)
      : begin_(supervoxels.count + std::size_t{1}, 0), voxels_(supervoxels.of_voxel.size()) {
    for (const std::uint32_t s : supervoxels.of_voxel) ++begin_[s + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t v = 0; v < voxels_.size(); ++v) voxels_[next[supervoxels.of_voxel[v]]++] = v;
  }

  std::span<const std::uint32_t> of(std::uint32_t s) const {
    return std::span(voxels_).subspan(begin_[s], begin_[s + 1] - begin_[s]);
  }

 private:
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> voxels_;
};

Region region_of(std::span<const std::uint32_t> voxels, const VoxelGrid& grid, const std::vector<Vec3>& normals,
                 const View& view, double voxel_resolution) {
  Region region;
  for (const std::uint32_t v : voxels) {
    region.voxels += 1;
    region.points += grid.points[v];
    const double edge = voxel_edge(voxel_resolution, view, grid.centroid[v]);
    region.area += edge * edge;
    region.centroid += grid.centroid[v];
    region.normal_sum += normals[v];
    region.color_sum += grid.color_sum[v];
  }
  region.centroid = (1 / region.voxels) * region.centroid;
  for (const std::uint32_t v : voxels) region.scatter += outer(grid.centroid[v] - region.centroid);
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
                               const Supervoxels& supervoxels, const View& view, double voxel_resolution) {
  RegionGraph graph;
  const VoxelsBySupervoxel voxels(supervoxels);
  graph.regions.reserve(supervoxels.count);
  std::vector<std::uint32_t> met(supervoxels.count, 0);  // the last supervoxel + 1 that met this one
  for (std::uint32_t a = 0; a < supervoxels.count; ++a) {
    graph.regions.push_back(region_of(voxels.of(a), grid, normals, view, voxel_resolution));
    const std::size_t first = graph.edges.size();
    for (const std::uint32_t v : voxels.of(a)) {
      for (const std::uint32_t u : adjacency.of(v)) {
        const std::uint32_t b = supervoxels.of_voxel[u];
        if (b <= a || met[b] == a + 1) continue;
        met[b] = a + 1;
        graph.edges.push_back({a, b});
      }
    }
    std::sort(graph.edges.begin() + static_cast<std::ptrdiff_t>(first), graph.edges.end(),
              [](const RegionEdge& p, const RegionEdge& q) { return p.b < q.b; });
  }
  return graph;
}

}  // namespace segserve
