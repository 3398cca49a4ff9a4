// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/component_bridging.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/island_links.hpp"
#include "core/voxels/voxel_links.hpp"

namespace segserve {
namespace {

/// Connected components with their numbers of voxels. The smallest voxel of a component is its name.
class Components {
 public:
  explicit Components(std::size_t voxels) : parent_(voxels), voxels_(voxels, 1) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  std::uint32_t of(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  std::uint32_t voxels(std::uint32_t component) const { return voxels_[component]; }

  /// Unites the components of u and v, and returns the united one.
  std::uint32_t unite(std::uint32_t u, std::uint32_t v) {
    const auto [a, b] = std::minmax({of(u), of(v)});
    if (a == b) return a;
    parent_[b] = a;
    voxels_[a] += voxels_[b];
    return a;
  }

  /// Unites v with its neighbors before it, most of which are in one component already.
  void unite(std::uint32_t v, std::span<const std::uint32_t> neighbors) {
    std::uint32_t component = v;
    for (const std::uint32_t u : neighbors) {
      if (u > v) break;
      if (parent_[u] != component) component = unite(u, component);
    }
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint32_t> voxels_;
};

Components components_of(const VoxelGrid& grid, const VoxelAdjacency& adjacency, StopCheck& check) {
  Components components(grid.size());
  check.for_each(0, grid.size(), [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    components.unite(v, adjacency.of(v));
    return 1 + adjacency.of(v).size();
  });
  return components;
}

/// Finds the voxels near one voxel after another. Each row of cells of the block around a voxel has a position in the
/// sorted keys. Voxels are asked for in ascending order, so that positions only move forward, by steps that double.
class BlockSearch {
 public:
  BlockSearch(const VoxelGrid& grid, int reach)
      : keys_(grid.key), reach_(reach), row_(static_cast<std::size_t>((2 * reach + 1) * (2 * reach + 1))) {}

  /// Calls callback(u) for every voxel u at most `reach` cells from v, in ascending order, v included. v must be larger
  /// than in all earlier calls.
  template <typename Callback>
  void for_block_around(std::uint32_t v, Callback&& callback) {
    constexpr std::int64_t kRowStep = std::int64_t{1} << kCellBits;
    auto row = row_.begin();
    for (std::int64_t dz = -reach_; dz <= reach_; ++dz) {
      for (std::int64_t dy = -reach_; dy <= reach_; ++dy, ++row) {
        const VoxelKey first = keys_[v] + static_cast<VoxelKey>((dz * kRowStep + dy) * kRowStep - reach_);
        *row = first_from(*row, first);
        for (std::size_t u = *row; u < keys_.size() && keys_[u] <= first + 2 * static_cast<VoxelKey>(reach_); ++u) {
          callback(static_cast<std::uint32_t>(u));
        }
      }
    }
  }

 private:
  /// The first position from `position` on whose key is at least `key`.
  std::size_t first_from(std::size_t position, VoxelKey key) const {
    std::size_t end = position;
    for (std::size_t step = 1; end < keys_.size() && keys_[end] < key; step *= 2) {
      position = end + 1;
      end += step;
    }
    const auto begin = keys_.begin();
    const auto last = static_cast<std::ptrdiff_t>(std::min(end, keys_.size()));
    return static_cast<std::size_t>(std::lower_bound(begin + static_cast<std::ptrdiff_t>(position), begin + last, key) -
                                    begin);
  }

  const std::vector<VoxelKey>& keys_;
  const std::int64_t reach_;
  std::vector<std::size_t> row_;
};

}  // namespace

absl::Status bridge_components(const FrameContext& frame, const VoxelGrid& grid, const BridgingOptions& options,
                               VoxelAdjacency& adjacency) {
  StopCheck check(frame.stop);
  Components components = components_of(grid, adjacency, check);
  const auto is_small = [&](std::uint32_t component) { return components.voxels(component) < options.voxels; };
  std::vector<std::uint32_t> in_small(grid.size());  // the voxels of small components
  std::iota(in_small.begin(), in_small.end(), 0U);
  std::vector<VoxelLink> bridges;
  for (int reach = 2; reach <= options.reach; ++reach) {
    std::size_t left = 0;
    check.for_each(0, in_small.size(), [&](std::size_t i) {
      if (is_small(components.of(in_small[i]))) in_small[left++] = in_small[i];
    });
    in_small.resize(left);
    const std::size_t first = bridges.size();
    BlockSearch search(grid, reach);
    check.for_each(0, in_small.size(), [&](std::size_t i) {
      const auto width = static_cast<std::uint64_t>(2 * reach) + 1;
      std::uint64_t visits = width * width;  // rows of cells
      const std::uint32_t v = in_small[i], home = components.of(v);
      search.for_block_around(v, [&](std::uint32_t u) {
        ++visits;
        const std::uint32_t other = components.of(u);
        // Two small components find each other, so that one bridge would be found twice.
        if (other != home && (u > v || !is_small(other))) bridges.push_back({v, u});
      });
      return visits;
    });
    // Components are united after the search, so that the bridges do not depend on the order of the voxels.
    check.for_each(first, bridges.size(), [&](std::size_t i) { components.unite(bridges[i].from, bridges[i].to); });
  }
  if (frame.view().kind == ViewKind::kCamera) {
    std::vector<IslandVoxel> islands;
    check.for_each(0, in_small.size(), [&](std::size_t i) {
      const std::uint32_t component = components.of(in_small[i]);
      if (is_small(component)) islands.push_back({in_small[i], component});
    });
    link_islands_by_depth(grid, islands, check, bridges);
  }
  if (!bridges.empty() && !check.stopped()) add_links(bridges, check, adjacency);
  return check.status();
}

}  // namespace segserve
