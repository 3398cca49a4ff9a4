// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/island_links.hpp"

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <limits>
#include <unordered_map>

namespace segserve {
namespace {

constexpr std::int64_t kAside = 2;  // columns
constexpr std::uint64_t kColumnsAround = (2 * kAside + 1) * (2 * kAside + 1);
constexpr VoxelKey kColumnMask = (VoxelKey{1} << (2U * kCellBits)) - 1;

/// The cell of x and y.
VoxelKey column_of(VoxelKey key) { return key & kColumnMask; }
std::int64_t layer_of(VoxelKey key) { return static_cast<std::int64_t>(key >> (2U * kCellBits)); }

/// Calls callback(column) for the columns around that of a voxel.
template <typename Callback>
void for_columns_around(VoxelKey key, Callback&& callback) {
  constexpr std::int64_t kRowStep = std::int64_t{1} << kCellBits;
  for (std::int64_t dy = -kAside; dy <= kAside; ++dy) {
    for (std::int64_t dx = -kAside; dx <= kAside; ++dx) {
      callback(column_of(key + static_cast<VoxelKey>(dy * kRowStep + dx)));
    }
  }
}

/// A set of columns that may say of some others, too, that it has them.
class ColumnFilter {
 public:
  void add(VoxelKey column) { bits_.set(place(column)); }
  bool may_have(VoxelKey column) const { return bits_.test(place(column)); }

 private:
  static constexpr unsigned kBits = 16;
  static std::size_t place(VoxelKey column) {
    return static_cast<std::size_t>((column * 0x9E3779B97F4A7C15U) >> (64U - kBits));
  }
  std::bitset<std::size_t{1} << kBits> bits_;
};

/// A voxel of no island in a column that some island looks into.
struct Candidate {
  VoxelKey column = 0;
  std::uint32_t voxel = 0;
  bool operator<(const Candidate& o) const { return column != o.column ? column < o.column : voxel < o.voxel; }
};

struct NearestInDepth {
  std::int64_t layers = std::numeric_limits<std::int64_t>::max();
  VoxelLink link{};
};

std::vector<Candidate> find_candidates(const VoxelGrid& grid, const std::vector<IslandVoxel>& islands,
                                       StopCheck& check) {
  ColumnFilter wanted;
  for (const IslandVoxel& island : islands) {
    for_columns_around(grid.key[island.voxel], [&wanted](VoxelKey column) { wanted.add(column); });
  }
  std::vector<Candidate> candidates;
  auto island = islands.begin();
  check.for_each(0, grid.size(), [&](std::size_t v) {
    if (island != islands.end() && island->voxel == v) {
      ++island;
      return;
    }
    const VoxelKey column = column_of(grid.key[v]);
    if (wanted.may_have(column)) candidates.push_back({column, static_cast<std::uint32_t>(v)});
  });
  std::ranges::sort(candidates, std::less<>());
  return candidates;
}

}  // namespace

void link_islands_by_depth(const VoxelGrid& grid, const std::vector<IslandVoxel>& islands, StopCheck& check,
                           std::vector<VoxelLink>& links) {
  if (islands.empty()) return;
  const std::vector<Candidate> candidates = find_candidates(grid, islands, check);
  std::vector<std::uint32_t> components;  // in the order of their first voxels
  std::unordered_map<std::uint32_t, NearestInDepth> nearest;
  check.for_each(0, islands.size(), [&](std::size_t i) {
    const auto [voxel, component] = islands[i];
    const auto [entry, is_new] = nearest.try_emplace(component);
    if (is_new) components.push_back(component);
    NearestInDepth& best = entry->second;
    const std::int64_t layer = layer_of(grid.key[voxel]);
    const auto look_at = [&, v = voxel](const Candidate& candidate) {
      const std::int64_t layers = std::abs(layer_of(grid.key[candidate.voxel]) - layer);
      if (layers < best.layers) best = {layers, {v, candidate.voxel}};
    };
    for_columns_around(grid.key[voxel], [&, v = voxel](VoxelKey column) {
      // Voxels are numbered by their layers first, so that the nearest ones are right before and after this number.
      const auto after = std::ranges::lower_bound(candidates, Candidate{column, v}, std::less<>());
      if (after != candidates.end() && after->column == column) look_at(*after);
      if (after != candidates.begin() && after[-1].column == column) look_at(after[-1]);
    });
    return kColumnsAround;
  });
  for (const std::uint32_t component : components) {
    const NearestInDepth& best = nearest[component];
    if (best.layers < std::numeric_limits<std::int64_t>::max()) links.push_back(best.link);
  }
}

}  // namespace segserve
