#include "segserve/graph/region_graph.hpp"

#include <algorithm>
#include <bit>
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

/// The sums over the voxels of every supervoxel. Voxel by voxel, as they lie in memory: each region still adds up its
/// own in ascending order.
void sum_up(const VoxelGrid& grid, const std::vector<Vec3>& normals, const Supervoxels& supervoxels, const View& view,
            double voxel_resolution, StopCheck& check, std::vector<Region>& regions) {
  regions.assign(supervoxels.count, Region{});
  check.for_each(0, grid.size(), [&](std::size_t v) {
    Region& region = regions[supervoxels.of_voxel[v]];
    region.voxels += 1;
    region.points += grid.points[v];
    const double edge = voxel_edge(voxel_resolution, view, grid.centroid[v]);
    region.area += edge * edge;
    region.centroid += grid.centroid[v];
    region.normal_sum += normals[v];
    region.color_sum += grid.color_sum[v];
  });
  check.for_each(0, regions.size(),
                 [&](std::size_t r) { regions[r].centroid = (1 / regions[r].voxels) * regions[r].centroid; });
  check.for_each(0, grid.size(), [&](std::size_t v) {
    Region& region = regions[supervoxels.of_voxel[v]];
    region.scatter += outer(grid.centroid[v] - region.centroid);
  });
}

/// Edges of a few regions: a bit for each pair of them, set by every pair of voxels, then read in order.
void find_few_edges(const VoxelAdjacency& adjacency, const Supervoxels& supervoxels, StopCheck& check,
                    std::vector<RegionEdge>& edges) {
  const std::size_t words = (supervoxels.count + std::size_t{63}) / 64;
  std::vector<std::uint64_t> met(words * supervoxels.count, 0);
  // Both ways and within regions as well: what is asked for each pair of voxels is mispredicted too often.
  check.for_each(0, supervoxels.of_voxel.size(), [&](std::size_t v) {
    const auto larger = adjacency.after(static_cast<std::uint32_t>(v));
    std::uint64_t* row = met.data() + words * supervoxels.of_voxel[v];
    for (const std::uint32_t u : larger) {
      const std::uint32_t t = supervoxels.of_voxel[u];
      row[t / 64] |= std::uint64_t{1} << (t % 64);
    }
    return 1 + larger.size();
  });
  const auto for_each_met = [&](auto&& each) {
    check.for_each(0, met.size(), [&](std::size_t word) {
      const auto a = static_cast<std::uint32_t>(word / words);
      for (std::uint64_t bits = met[word]; bits != 0; bits &= bits - 1) {
        each(a, static_cast<std::uint32_t>(word % words * 64) + static_cast<std::uint32_t>(std::countr_zero(bits)));
      }
    });
  };
  for_each_met([&](std::uint32_t a, std::uint32_t b) {
    if (b < a) met[words * b + a / 64] |= std::uint64_t{1} << (a % 64);
  });
  for_each_met([&](std::uint32_t a, std::uint32_t b) {
    if (a < b) edges.push_back({a, b});
  });
}

/// Edges of many regions: one region after the other meets its neighbours.
void find_many_edges(const VoxelAdjacency& adjacency, const Supervoxels& supervoxels, StopCheck& check,
                     std::vector<RegionEdge>& edges) {
  const VoxelsBySupervoxel voxels(supervoxels, check);
  std::vector<std::uint32_t> met(supervoxels.count, 0);  // the last supervoxel + 1 that met this one
  for (std::uint32_t a = 0; a < supervoxels.count && !check.stopped(); ++a) {
    const std::size_t first = edges.size();
    check.for_each(0, voxels.of(a).size(), [&, of_a = voxels.of(a)](std::size_t i) {
      for (const std::uint32_t u : adjacency.of(of_a[i])) {
        const std::uint32_t b = supervoxels.of_voxel[u];
        if (b <= a || met[b] == a + 1) continue;
        met[b] = a + 1;
        edges.push_back({a, b});
      }
      return 1 + adjacency.of(of_a[i]).size();
    });
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(first), edges.end(),
              [](const RegionEdge& p, const RegionEdge& q) { return p.b < q.b; });
  }
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
  // At most 16 bytes of bits for each voxel.
  const std::size_t words = (supervoxels.count + std::size_t{63}) / 64 * supervoxels.count;
  const bool few = words <= 2 * grid.size();
  RegionGraph graph;
  StopCheck check(stop);
  sum_up(grid, normals, supervoxels, view, voxel_resolution, check, graph.regions);
  (few ? find_few_edges : find_many_edges)(adjacency, supervoxels, check, graph.edges);
  return graph;
}

}  // namespace segserve
