#include "core/region_graph/region_graph.hpp"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

/// 64-bit words with a bit for each supervoxel.
std::size_t words_of(const Supervoxels& supervoxels) { return (supervoxels.count + std::size_t{63}) / 64; }

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

/// Writes the contacts of voxel v with those of its neighbours that are larger and of other supervoxels; returns where
/// they end. No branches, which would be mispredicted for a third of the neighbours; a function of its own, as its
/// variables then stay in registers.
__attribute__((noinline)) Contact* find_contacts_of(std::uint32_t v, std::span<const std::uint32_t> neighbors,
                                                    const std::uint32_t* of_voxel, Contact* out) {
  const std::uint32_t s = of_voxel[v];
  for (const std::uint32_t u : neighbors) {
    *out = {v, u};
    out += static_cast<std::ptrdiff_t>(of_voxel[u] != s);
  }
  return out;
}

/// Room for some contacts more, after those of the voxels before v of V: for as many as there will be, to go by those.
/// Growing by halves would waste 4 bytes a point.
void make_room(std::vector<Contact>& contacts, std::size_t needed, std::size_t v, std::size_t voxels) {
  if (needed <= contacts.size()) return;
  const double share = static_cast<double>(v + 1) / static_cast<double>(voxels);
  contacts.resize(
      std::max({needed + needed / 16, static_cast<std::size_t>(1.05 * static_cast<double>(needed) / share)}));
}

/// One pass for edges and borders: 0.4 ms off a frame by the border method.
std::span<const Contact> find_contacts(const VoxelAdjacency& adjacency, const Supervoxels& supervoxels,
                                       StopCheck& check, std::vector<Contact>& buffer) {
  const std::size_t voxels = supervoxels.of_voxel.size();
  std::size_t found = 0;
  if (buffer.size() < voxels) buffer.resize(voxels);
  check.for_each(0, voxels, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    const auto neighbors = adjacency.after(v);
    make_room(buffer, found + neighbors.size() + 1, i, voxels);
    const Contact* const end = find_contacts_of(v, neighbors, supervoxels.of_voxel.data(), buffer.data() + found);
    found = static_cast<std::size_t>(end - buffer.data());
    return 1 + neighbors.size();
  });
  return std::span(buffer).first(found);
}

RegionEdge edge_of(const Contact& contact, const std::vector<std::uint32_t>& of_voxel) {
  const auto [a, b] = std::minmax({of_voxel[contact.v], of_voxel[contact.u]});
  return {a, b};
}

/// Edges of a few regions: a bit for each pair of them, set by every contact, then read in order.
void find_few_edges(const RegionGraph& graph, const Supervoxels& supervoxels, StopCheck& check, GraphScratch& scratch,
                    std::vector<RegionEdge>& edges) {
  const std::size_t words = words_of(supervoxels);
  std::vector<std::uint64_t>& met = scratch.met;
  met.assign(words * supervoxels.count, 0);
  check.for_each(0, graph.contacts.size(), [&](std::size_t c) {
    const RegionEdge edge = edge_of(graph.contacts[c], supervoxels.of_voxel);
    met[words * edge.a + edge.b / 64] |= std::uint64_t{1} << (edge.b % 64);
  });
  check.for_each(0, met.size(), [&](std::size_t word) {
    for (std::uint64_t bits = met[word]; bits != 0; bits &= bits - 1) {
      const auto first = static_cast<std::uint32_t>(word % words * 64);
      edges.push_back(
          {static_cast<std::uint32_t>(word / words), first + static_cast<std::uint32_t>(std::countr_zero(bits))});
    }
  });
}

/// Edges of many regions: the contacts sorted by their smaller region, by counting; then each meets its neighbours.
void find_many_edges(const RegionGraph& graph, const Supervoxels& supervoxels, StopCheck& check, GraphScratch& scratch,
                     std::vector<RegionEdge>& edges) {
  const std::span<const Contact> contacts = graph.contacts;
  std::vector<std::uint32_t>&begin = scratch.begin, &next = scratch.next, &larger = scratch.larger;
  begin.assign(supervoxels.count + std::size_t{1}, 0);
  check.for_each(0, contacts.size(), [&](std::size_t c) { ++begin[edge_of(contacts[c], supervoxels.of_voxel).a + 1]; });
  check.for_each(0, supervoxels.count, [&](std::size_t s) { begin[s + 1] += begin[s]; });
  next.assign(begin.begin(), begin.end() - 1);
  larger.resize(contacts.size());
  check.for_each(0, contacts.size(), [&](std::size_t c) {
    const RegionEdge edge = edge_of(contacts[c], supervoxels.of_voxel);
    larger[next[edge.a]++] = edge.b;
  });
  std::vector<std::uint32_t>& met = scratch.last_met;  // the last supervoxel + 1 that met this one
  met.assign(supervoxels.count, 0);
  for (std::uint32_t a = 0; a < supervoxels.count && !check.after(1); ++a) {
    const std::size_t first = edges.size();
    check.for_each(begin[a], begin[a + 1], [&](std::size_t i) {
      if (std::exchange(met[larger[i]], a + 1) != a + 1) edges.push_back({a, larger[i]});
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

void build_region_graph(const VoxelGrid& grid, const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                        const Supervoxels& supervoxels, const View& view, double voxel_resolution,
                        const StopToken& stop, GraphScratch& scratch, RegionGraph& graph) {
  // At most 16 bytes of bits for each voxel.
  const bool few = words_of(supervoxels) * supervoxels.count <= 2 * grid.size();
  StopCheck check(stop);
  sum_up(grid, normals, supervoxels, view, voxel_resolution, check, graph.regions);
  graph.contacts = find_contacts(adjacency, supervoxels, check, scratch.contacts);
  graph.edges.clear();
  (few ? find_few_edges : find_many_edges)(graph, supervoxels, check, scratch, graph.edges);
}

}  // namespace segserve
