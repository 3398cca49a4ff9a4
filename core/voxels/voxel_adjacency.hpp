#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/voxels/voxel_grid.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// The neighbours of every voxel as compressed sparse rows: those of v, ascending and without v itself, are
/// neighbor[offset[v] .. offset[v + 1]).
struct VoxelAdjacency {
  std::vector<std::uint32_t> offset;  ///< V + 1
  std::vector<std::uint32_t> neighbor;

  std::span<const std::uint32_t> of(std::uint32_t v) const {
    return std::span(neighbor).subspan(offset[v], offset[v + 1] - offset[v]);
  }

  /// Those larger than v: every pair of neighbours once.
  std::span<const std::uint32_t> after(std::uint32_t v) const {
    const std::span<const std::uint32_t> all = of(v);
    std::size_t first = all.size();
    while (first > 0 && all[first - 1] > v) --first;
    return all.subspan(first);
  }
};

/// The 26-neighbourhood. O(V), without hashing: one pointer for each of the nine rows (dy, dz) moves over the sorted
/// keys. If stopped, what it found is useless.
void find_adjacency(const VoxelGrid& grid, VoxelAdjacency& adjacency, const StopToken& stop = {});

}  // namespace segserve
