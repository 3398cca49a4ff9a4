// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxel_adjacency.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "core/base/stop_check.hpp"

namespace segserve {
namespace {

constexpr std::int64_t kRowStep = std::int64_t{1} << kCellBits;
constexpr std::int64_t kLayerStep = std::int64_t{1} << (2 * kCellBits);
constexpr std::size_t kMostNeighbors = 26;

/// The difference between the key of a voxel and the smallest key of a neighbor in a row of cells, for each row around
/// the voxel, in ascending order.
constexpr std::array<std::int64_t, 9> kRowOffsets = [] {
  std::array<std::int64_t, 9> offsets{};
  std::size_t row = 0;
  for (std::int64_t dz = -1; dz <= 1; ++dz) {
    for (std::int64_t dy = -1; dy <= 1; ++dy) offsets[row++] = dz * kLayerStep + dy * kRowStep - 1;
  }
  return offsets;
}();
constexpr std::size_t kOwnRow = 4;

/// Searches the sorted keys, with room to look beyond the last one, by one pointer for each row.
class NeighborSearch {
 public:
  /// The number of entries that `find` may write beyond those that it finds.
  static constexpr std::size_t kSurplus = 4;

  explicit NeighborSearch(const std::vector<VoxelKey>& keys) : keys_(keys.size() + 4, ~VoxelKey{0}) {
    keys_[0] = 0;  // No voxel has this key.
    std::ranges::copy(keys, keys_.begin() + 1);
  }

  /// Writes the neighbors of v and returns where they end. Must be called for ascending v. The only branches are those
  /// of the search, which mostly takes one step or none. The neighbors in a row stand side by side, so that one store
  /// writes all of them.
  std::uint32_t* find(std::uint32_t v, std::uint32_t* out) {
    const VoxelKey* const key = keys_.data() + 1;
    const VoxelKey own = key[v];
#pragma GCC unroll 9
    for (std::size_t row = 0; row < kRowOffsets.size(); ++row) {
      if (row == kOwnRow) {
        *out = v - 1;
        out += static_cast<std::ptrdiff_t>(own - 1 == *(key + v - 1));
        *out = v + 1;
        out += static_cast<std::ptrdiff_t>(own + 1 == *(key + v + 1));
        continue;
      }
      const VoxelKey first = own + static_cast<VoxelKey>(kRowOffsets[row]), last = first + 2;
      std::size_t u = pointer_[row];
      u += static_cast<std::size_t>(key[u] < first);
      while (key[u] < first) ++u;
      pointer_[row] = static_cast<std::uint32_t>(u);
      const Four found = Four{0, 1, 2, 3} + static_cast<std::uint32_t>(u);
      std::memcpy(out, &found, sizeof(found));
      out += static_cast<std::ptrdiff_t>(key[u] <= last) + static_cast<std::ptrdiff_t>(key[u + 1] <= last) +
             static_cast<std::ptrdiff_t>(key[u + 2] <= last);
    }
    return out;
  }

 private:
  using Four = std::uint32_t __attribute__((vector_size(16)));  // SSE2, NEON or scalar code

  std::vector<VoxelKey> keys_;
  std::array<std::uint32_t, 9> pointer_{};
};

/// Makes room for the neighbors of all voxels, if these have as many as the voxels before v, and for some more in any
/// case. Doubling the room would waste memory: for large clouds the neighbors take more of it than anything else.
void grow(std::size_t v, std::size_t voxels, std::size_t found, std::vector<std::uint32_t>& neighbor) {
  constexpr std::size_t kUsual = 16, kLeastMore = 4096;
  const std::size_t expected = v < kLeastMore ? kUsual * voxels : found / v * voxels + voxels;
  const std::size_t size = std::max(expected, found + found / 16) + kLeastMore;
  neighbor.reserve(size);  // exactly
  neighbor.resize(size);
}

}  // namespace

absl::Status find_adjacency(const FrameContext& frame, const VoxelGrid& grid, VoxelAdjacency& adjacency) {
  StopCheck check(frame.stop);
  NeighborSearch search(grid.key);
  std::vector<std::uint32_t>& neighbor = adjacency.neighbor;
  adjacency.offset.resize(grid.size() + 1);
  adjacency.offset[0] = 0;
  std::size_t found = 0;
  check.for_each(0, grid.size(), [&](std::size_t v) {
    if (found + kMostNeighbors + NeighborSearch::kSurplus > neighbor.size()) grow(v, grid.size(), found, neighbor);
    const std::uint32_t* const end = search.find(static_cast<std::uint32_t>(v), neighbor.data() + found);
    const std::size_t before = std::exchange(found, static_cast<std::size_t>(end - neighbor.data()));
    adjacency.offset[v + 1] = static_cast<std::uint32_t>(found);
    return kRowOffsets.size() + found - before;
  });
  neighbor.resize(found);
  return check.status();
}

}  // namespace segserve
