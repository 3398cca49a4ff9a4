#include "segserve/voxel/islands.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace segserve {
namespace {

/// Connected components with their areas, named by their smallest voxel.
class Components {
 public:
  explicit Components(std::vector<double> area) : parent_(area.size()), area_(std::move(area)) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  std::uint32_t of(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  double area(std::uint32_t component) const { return area_[component]; }

  void unite(std::uint32_t u, std::uint32_t v) {
    const auto [a, b] = std::minmax({of(u), of(v)});
    if (a == b) return;
    parent_[b] = a;
    area_[a] += area_[b];
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<double> area_;
};

Components components_of(const VoxelGrid& grid, const View& view, double voxel_resolution,
                         const VoxelAdjacency& adjacency) {
  std::vector<double> area(grid.size());
  for (std::size_t v = 0; v < area.size(); ++v) {
    const double edge = voxel_edge(voxel_resolution, view, grid.centroid[v]);
    area[v] = edge * edge;
  }
  Components components(std::move(area));
  for (std::uint32_t v = 0; v < grid.size(); ++v) {
    for (const std::uint32_t u : adjacency.of(v)) {
      if (u > v) break;
      components.unite(u, v);
    }
  }
  return components;
}

struct Bridge {
  std::uint32_t from, to;
  auto operator<=>(const Bridge&) const = default;
};

/// Calls back for every voxel at most `reach` cells from v, ascending, v included.
template <typename Callback>
void for_block_around(const VoxelGrid& grid, std::uint32_t v, int reach, Callback&& callback) {
  constexpr std::int64_t kRowStep = std::int64_t{1} << kCellBits;
  auto row = grid.key.begin();
  for (std::int64_t dz = -reach; dz <= reach; ++dz) {
    for (std::int64_t dy = -reach; dy <= reach; ++dy) {
      const VoxelKey first = grid.key[v] + static_cast<VoxelKey>((dz * kRowStep + dy) * kRowStep - reach);
      row = std::lower_bound(row, grid.key.end(), first);
      for (; row != grid.key.end() && *row <= first + 2 * static_cast<VoxelKey>(reach); ++row) {
        callback(static_cast<std::uint32_t>(row - grid.key.begin()));
      }
    }
  }
}

/// Both directions of each bridge become neighbours; ascending and distinct.
void add_bridges(std::vector<Bridge>& bridges, VoxelAdjacency& adjacency) {
  for (std::size_t i = 0, count = bridges.size(); i < count; ++i) bridges.push_back({bridges[i].to, bridges[i].from});
  std::ranges::sort(bridges);
  bridges.erase(std::unique(bridges.begin(), bridges.end()), bridges.end());
  VoxelAdjacency result;
  result.offset.reserve(adjacency.offset.size());
  result.neighbor.reserve(adjacency.neighbor.size() + bridges.size());
  result.offset.push_back(0);
  auto bridge = bridges.begin();
  for (std::uint32_t v = 0; v + 1 < adjacency.offset.size(); ++v) {
    const auto old = adjacency.of(v);
    const auto middle = result.neighbor.insert(result.neighbor.end(), old.begin(), old.end()) - result.neighbor.begin();
    const auto grown = static_cast<std::ptrdiff_t>(result.neighbor.size());
    for (; bridge != bridges.end() && bridge->from == v; ++bridge) result.neighbor.push_back(bridge->to);
    const auto begin = result.neighbor.begin();
    std::inplace_merge(begin + middle, begin + grown, result.neighbor.end());
    result.offset.push_back(static_cast<std::uint32_t>(result.neighbor.size()));
  }
  adjacency = std::move(result);
}

}  // namespace

absl::Status bridge_islands(const VoxelGrid& grid, const View& view, double voxel_resolution,
                            const IslandOptions& options, const StopToken& stop, VoxelAdjacency& adjacency) {
  constexpr std::size_t kStopInterval = 1024;
  Components components = components_of(grid, view, voxel_resolution, adjacency);
  const auto is_island = [&](std::uint32_t component) { return components.area(component) < options.area; };
  std::vector<std::uint32_t> on_islands(grid.size());
  std::iota(on_islands.begin(), on_islands.end(), 0U);
  std::vector<Bridge> bridges;
  for (int reach = 2; reach <= options.reach; ++reach) {
    std::erase_if(on_islands, [&](std::uint32_t v) { return !is_island(components.of(v)); });
    const std::size_t first = bridges.size();
    for (std::size_t i = 0; i < on_islands.size(); ++i) {
      if (i % kStopInterval == 0 && stop.stopped()) return stop.check();
      const std::uint32_t v = on_islands[i], home = components.of(v);
      for_block_around(grid, v, reach, [&](std::uint32_t u) {
        const std::uint32_t other = components.of(u);
        // Of two islands, each finds the other.
        if (other != home && (u > v || !is_island(other))) bridges.push_back({v, u});
      });
    }
    // Only now, so that what a voxel finds does not depend on its turn.
    for (std::size_t i = first; i < bridges.size(); ++i) components.unite(bridges[i].from, bridges[i].to);
  }
  if (!bridges.empty()) add_bridges(bridges, adjacency);
  return absl::OkStatus();
}

}  // namespace segserve
