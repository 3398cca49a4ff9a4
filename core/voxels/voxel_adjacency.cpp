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

/// From a voxel's key to that of its neighbour with the smallest x in each row, ascending.
constexpr std::array<std::int64_t, 9> kRowOffsets = [] {
  std::array<std::int64_t, 9> offsets{};
  std::size_t row = 0;
  for (std::int64_t dz = -1; dz <= 1; ++dz) {
    for (std::int64_t dy = -1; dy <= 1; ++dy) offsets[row++] = dz * kLayerStep + dy * kRowStep - 1;
  }
  return offsets;
}();
constexpr std::size_t kOwnRow = 4;

/// The sorted keys with room to look beyond the last one, and a pointer into them for each row.
class NeighborSearch {
 public:
  /// How many more than it finds `find` may write.
  static constexpr std::size_t kSurplus = 4;

  explicit NeighborSearch(const std::vector<VoxelKey>& keys) : keys_(keys.size() + 4, ~VoxelKey{0}) {
    keys_[0] = 0;  // no voxel has this key
    std::ranges::copy(keys, keys_.begin() + 1);
  }

  /// Writes the neighbours of v, for ascending v. Without branches but the search's, and that one is mostly one step or
  /// none: 1.9 -> 1.1 ms a frame. The neighbours in a row stand side by side: all of them are one store, -> 0.8 ms.
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
  using Four = std::uint32_t __attribute__((vector_size(16)));  // SSE2, NEON or plain code

  std::vector<VoxelKey> keys_;
  std::array<std::uint32_t, 9> pointer_{};
};

/// Room for the neighbours of all voxels if they have as many as those before v, and for some more in any case. Not
/// twice the room, again and again: of large clouds the neighbours are the most memory of all.
void grow(std::size_t v, std::size_t voxels, std::size_t found, std::vector<std::uint32_t>& neighbor) {
  constexpr std::size_t kUsual = 16, kLeastMore = 4096;
  const std::size_t expected = v < kLeastMore ? kUsual * voxels : found / v * voxels + voxels;
  const std::size_t size = std::max(expected, found + found / 16) + kLeastMore;
  neighbor.reserve(size);  // exactly
  neighbor.resize(size);
}

}  // namespace

void find_adjacency(const VoxelGrid& grid, VoxelAdjacency& adjacency, const StopToken& stop) {
  StopCheck check(stop);
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
}

}  // namespace segserve
