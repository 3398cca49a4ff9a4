#include "segserve/voxel/adjacency.hpp"

#include <array>

namespace segserve {
namespace {

constexpr std::int64_t kRowStep = std::int64_t{1} << kCellBits;
constexpr std::int64_t kLayerStep = std::int64_t{1} << (2 * kCellBits);

/// From a voxel's key to that of its neighbour with the smallest x in each row, ascending.
constexpr std::array<std::int64_t, 9> kRowOffsets = [] {
  std::array<std::int64_t, 9> offsets{};
  std::size_t row = 0;
  for (std::int64_t dz = -1; dz <= 1; ++dz) {
    for (std::int64_t dy = -1; dy <= 1; ++dy) offsets[row++] = dz * kLayerStep + dy * kRowStep - 1;
  }
  return offsets;
}();

}  // namespace

void find_adjacency(const VoxelGrid& grid, VoxelAdjacency& adjacency, const StopToken& stop) {
  StopCheck check(stop);
  const auto count = static_cast<std::uint32_t>(grid.size());
  adjacency.offset.assign(1, 0);
  adjacency.offset.reserve(count + std::size_t{1});
  adjacency.neighbor.clear();
  std::array<std::uint32_t, 9> pointer{};
  const auto find_neighbors = [&](std::size_t v) {
    for (std::size_t row = 0; row < kRowOffsets.size(); ++row) {
      const VoxelKey first = grid.key[v] + static_cast<VoxelKey>(kRowOffsets[row]);
      std::uint32_t u = pointer[row];
      while (u < count && grid.key[u] < first) ++u;
      pointer[row] = u;
      for (; u < count && grid.key[u] <= first + 2; ++u) {
        if (u != v) adjacency.neighbor.push_back(u);
      }
    }
    const std::size_t found = adjacency.neighbor.size() - adjacency.offset.back();
    adjacency.offset.push_back(static_cast<std::uint32_t>(adjacency.neighbor.size()));
    return kRowOffsets.size() + found;
  };
  check.for_each(0, count, find_neighbors);
}

}  // namespace segserve
