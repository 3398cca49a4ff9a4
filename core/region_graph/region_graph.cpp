// SPDX-License-Identifier: Apache-2.0
#include "core/region_graph/region_graph.hpp"

#include <algorithm>
#include <span>

#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

/// Goes through the voxels in memory order. A region still adds up its own voxels in ascending order.
void sum_up_regions(const VoxelGrid& grid, const std::vector<Vec3>& normals, const Supervoxels& supervoxels,
                    StopCheck& check, std::vector<Region>& regions) {
  regions.assign(supervoxels.count, Region{});
  check.for_each(0, grid.size(), [&](std::size_t v) {
    Region& region = regions[supervoxels.supervoxel_of_voxel[v]];
    region.voxels += 1;
    region.points += grid.points[v];
    region.centroid += grid.centroid[v];
    region.normal_sum += normals[v];
    region.color_sum += grid.color_sum[v];
  });
  check.for_each(0, regions.size(),
                 [&](std::size_t r) { regions[r].centroid = (1 / regions[r].voxels) * regions[r].centroid; });
  check.for_each(0, grid.size(), [&](std::size_t v) {
    Region& region = regions[supervoxels.supervoxel_of_voxel[v]];
    region.scatter += outer(grid.centroid[v] - region.centroid);
  });
}

/// Writes the contacts of voxel v with larger voxels to `contacts`, which must have room for all neighbors and one
/// more, and returns where they end. It has no branches, which would often be mispredicted, and is a function of its
/// own so that its variables stay in registers.
__attribute__((noinline)) Contact* find_contacts_of(std::uint32_t v, std::span<const std::uint32_t> larger_neighbors,
                                                    const std::uint32_t* supervoxel_of_voxel, Contact* contacts) {
  const std::uint32_t supervoxel = supervoxel_of_voxel[v];
  for (const std::uint32_t u : larger_neighbors) {
    *contacts = {v, u};
    contacts += static_cast<std::ptrdiff_t>(supervoxel_of_voxel[u] != supervoxel);
  }
  return contacts;
}

/// Gives the list room for `size` contacts and, where it must grow, for as many as there will be if `share` of the
/// voxels are done. A vector that doubles would waste more memory.
void ensure_size(std::size_t size, double share, std::vector<Contact>& contacts) {
  if (size <= contacts.size()) return;
  const auto predicted = static_cast<std::size_t>(1.05 * static_cast<double>(size) / share);
  contacts.resize(std::max(size + size / 16, predicted));
}

void find_contacts(const VoxelAdjacency& adjacency, const Supervoxels& supervoxels, StopCheck& check,
                   std::vector<Contact>& contacts) {
  const std::size_t voxels = supervoxels.supervoxel_of_voxel.size();
  std::size_t found = 0;
  if (contacts.size() < voxels) contacts.resize(voxels);
  check.for_each(0, voxels, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    const auto neighbors = adjacency.after(v);
    ensure_size(found + neighbors.size() + 1, static_cast<double>(i + 1) / static_cast<double>(voxels), contacts);
    Contact* const first = contacts.data();
    found = static_cast<std::size_t>(
        find_contacts_of(v, neighbors, supervoxels.supervoxel_of_voxel.data(), first + found) - first);
    return 1 + neighbors.size();
  });
  contacts.resize(found);
}

/// Sorts the contacts by the smaller of their supervoxels, by counting.
void sort_contacts(const std::vector<Contact>& contacts, const Supervoxels& supervoxels, StopCheck& check,
                   RegionGraphConstruction::Scratch& s) {
  const std::uint32_t* const supervoxel = supervoxels.supervoxel_of_voxel.data();
  s.begin.assign(supervoxels.count + std::size_t{1}, 0);
  check.for_each(0, contacts.size(),
                 [&](std::size_t c) { ++s.begin[std::min(supervoxel[contacts[c].v], supervoxel[contacts[c].u]) + 1]; });
  check.for_each(0, supervoxels.count, [&](std::size_t r) { s.begin[r + 1] += s.begin[r]; });
  s.next.assign(s.begin.begin(), s.begin.end() - 1);
  s.sorted.resize(contacts.size());
  check.for_each(0, contacts.size(), [&](std::size_t c) {
    const std::uint32_t p = supervoxel[contacts[c].v], q = supervoxel[contacts[c].u];
    s.sorted[s.next[std::min(p, q)]++] = {static_cast<std::uint32_t>(c), std::max(p, q)};
  });
}

/// Finds the edges of each supervoxel to larger ones among its contacts.
void find_edges(const Supervoxels& supervoxels, StopCheck& check, RegionGraphConstruction::Scratch& s,
                RegionGraph& graph) {
  std::vector<RegionEdge>& edges = graph.edges;
  edges.clear();
  graph.edge_of_contact.resize(graph.contacts.size());
  s.edge_to.assign(supervoxels.count, 0);
  for (std::uint32_t a = 0; a < supervoxels.count && !check.after(1); ++a) {
    const std::size_t first = edges.size();
    check.for_each(s.begin[a], s.begin[a + 1], [&](std::size_t i) {
      const std::uint32_t b = s.sorted[i].larger_supervoxel;
      if (s.edge_to[b] > first) return;
      edges.push_back({a, b});
      s.edge_to[b] = static_cast<std::uint32_t>(edges.size());
    });
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(first), edges.end(),
              [](const RegionEdge& p, const RegionEdge& q) { return p.b < q.b; });
    for (std::size_t e = first; e < edges.size(); ++e) s.edge_to[edges[e].b] = static_cast<std::uint32_t>(e + 1);
    check.for_each(s.begin[a], s.begin[a + 1], [&](std::size_t i) {
      const auto [contact, b] = s.sorted[i];
      graph.edge_of_contact[contact] = s.edge_to[b] - 1;
    });
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
}

absl::Status RegionGraphConstruction::run(const FrameContext& frame, const VoxelGrid& grid,
                                          const VoxelAdjacency& adjacency, const std::vector<Vec3>& normals,
                                          const Supervoxels& supervoxels, RegionGraph& graph) {
  StopCheck check(frame.stop);
  sum_up_regions(grid, normals, supervoxels, check, graph.regions);
  find_contacts(adjacency, supervoxels, check, graph.contacts);
  sort_contacts(graph.contacts, supervoxels, check, scratch_);
  find_edges(supervoxels, check, scratch_, graph);
  return check.status();
}

}  // namespace segserve
