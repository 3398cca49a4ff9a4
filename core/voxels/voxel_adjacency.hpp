// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/voxels/voxel_grid.hpp"

namespace segserve {

/// The neighbors of every voxel as compressed sparse rows. The neighbors of v are neighbor[offset[v]] up to
/// neighbor[offset[v + 1] - 1], ascending and without v itself.
struct VoxelAdjacency {
  std::vector<std::uint32_t> offset;  ///< V + 1
  std::vector<std::uint32_t> neighbor;

  std::span<const std::uint32_t> of(std::uint32_t v) const {
    return std::span(neighbor).subspan(offset[v], offset[v + 1] - offset[v]);
  }

  /// The neighbors that are larger than v. Over all v, these are the pairs of neighbors, each once.
  std::span<const std::uint32_t> after(std::uint32_t v) const {
    const std::span<const std::uint32_t> all = of(v);
    std::size_t first = all.size();
    while (first > 0 && all[first - 1] > v) --first;
    return all.subspan(first);
  }
};

/// Finds the 26-neighborhood of every voxel. O(V) without hashing: one pointer for each of the nine rows (dy, dz) moves
/// over the sorted keys. CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_adjacency(const FrameContext& frame, const VoxelGrid& grid, VoxelAdjacency& adjacency);

}  // namespace segserve
