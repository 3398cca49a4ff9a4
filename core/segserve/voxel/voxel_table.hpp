#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "segserve/voxel/voxel_key.hpp"

namespace segserve {

/// A voxel and integer sums over its points: exact, so their order does not matter. One cache line.
struct alignas(64) VoxelSums {
  VoxelKey key = 0;
  std::int64_t x = 0, y = 0, z = 0;  // fixed point
  std::uint64_t red = 0, green = 0, blue = 0;
  std::uint64_t points = 0;

  void add(const VoxelSums& o) {
    x += o.x, y += o.y, z += o.z;
    red += o.red, green += o.green, blue += o.blue;
    points += o.points;
  }
};

/// Open-addressing hash table from voxel keys to consecutive slots 1, 2, ..; load at most one half. It holds the slots
/// alone, and compares the keys in the sums, which are needed next anyway.
class VoxelTable {
 public:
  VoxelTable() { clear(); }

  void clear() {
    if (places_.size() > kSmallest && places_.size() > 16 * voxels_.size()) {
      places_.resize(kSmallest);  // a small cloud after a large one must not pay for the large table
    }
    places_.assign(places_.empty() ? kSmallest : places_.size(), 0);
    voxels_.clear();
  }

  /// In the order of their slots.
  const std::vector<VoxelSums>& voxels() const { return voxels_; }
  VoxelSums& voxel(std::uint32_t slot) { return voxels_[slot - 1]; }

  static std::uint32_t hash(VoxelKey key) { return static_cast<std::uint32_t>((key * 0x9e3779b97f4a7c15ULL) >> 32U); }

  // Both on the way to find_or_insert, the one long before the other: where the table is larger than the caches, many
  // look-ups wait for memory at the same time.
  void prefetch_place(std::uint32_t hash) const { __builtin_prefetch(&places_[home(hash)]); }
  void prefetch_voxel(std::uint32_t hash) const {
    if (const std::uint32_t slot = places_[home(hash)]; slot != 0) __builtin_prefetch(&voxels_[slot - 1]);
  }

  /// The key's slot; a new key gets the next one, its sums 0.
  std::uint32_t find_or_insert(VoxelKey key, std::uint32_t hash) {
    std::size_t place = home(hash);
    for (; places_[place] != 0; place = after(place)) {
      if (voxels_[places_[place] - 1].key == key) return places_[place];
    }
    if (2 * (voxels_.size() + 1) > places_.size()) {
      grow();
      return find_or_insert(key, hash);
    }
    voxels_.emplace_back().key = key;
    return places_[place] = static_cast<std::uint32_t>(voxels_.size());
  }

 private:
  static constexpr std::size_t kSmallest = std::size_t{1} << 15U;

  std::size_t home(std::uint32_t hash) const { return hash & (places_.size() - 1); }
  std::size_t after(std::size_t place) const { return (place + 1) & (places_.size() - 1); }

  void grow() {
    places_.assign(2 * places_.size(), 0);
    for (std::size_t i = 0; i < voxels_.size(); ++i) {
      std::size_t place = home(hash(voxels_[i].key));
      while (places_[place] != 0) place = after(place);
      places_[place] = static_cast<std::uint32_t>(i + 1);
    }
  }

  std::vector<std::uint32_t> places_;  // slots, 0 where free
  std::vector<VoxelSums> voxels_;
};

}  // namespace segserve
