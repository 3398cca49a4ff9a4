#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "segserve/voxel/kernels/kernels.hpp"
#include "segserve/voxel/voxel_key.hpp"

namespace segserve {

/// A voxel and integer sums over its points: exact, so their order does not matter. One cache line.
struct alignas(64) VoxelSums {
  std::int64_t x = 0, y = 0, z = 0;  // fixed point
  VoxelKey key = 0;
  std::uint64_t red = 0, green = 0, blue = 0;
  std::uint64_t points = 0;

  void add(const VoxelSums& o) {
    x += o.x, y += o.y, z += o.z;
    red += o.red, green += o.green, blue += o.blue;
    points += o.points;
  }

  /// Adds what is between two running sums over `count` points.
  void add(const PointSums& begin, const PointSums& end, std::uint64_t count) {
    constexpr std::uint64_t kColor = (std::uint64_t{1} << PointSums::kColorBits) - 1;
    x += end.x - begin.x, y += end.y - begin.y, z += end.z - begin.z;
    const std::uint64_t color = end.color - begin.color;
    red += color >> (2 * PointSums::kColorBits);
    green += color >> PointSums::kColorBits & kColor;
    blue += color & kColor;
    points += count;
  }
};

/// Voxels in blocks, so that they never move: for those who grow by millions, no copies and no second place to copy to.
class VoxelList {
 public:
  std::size_t size() const { return size_; }
  const VoxelSums& operator[](std::size_t i) const { return blocks_[i / kBlock][i % kBlock]; }
  VoxelSums& operator[](std::size_t i) { return blocks_[i / kBlock][i % kBlock]; }

  /// Room for so many; what stands there is no voxel until `resize` says so.
  void reserve(std::size_t count) {
    while (blocks_.size() * kBlock < count) blocks_.push_back(std::make_unique_for_overwrite<VoxelSums[]>(kBlock));
  }
  void resize(std::size_t size) { size_ = size; }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 13U;

  std::vector<std::unique_ptr<VoxelSums[]>> blocks_;
  std::size_t size_ = 0;
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
    voxels_.resize(0);
  }

  /// In the order of their slots.
  const VoxelList& voxels() const { return voxels_; }
  VoxelSums& voxel(std::uint32_t slot) { return voxels_[slot - 1]; }

  static std::uint32_t hash(VoxelKey key) { return static_cast<std::uint32_t>((key * 0x9e3779b97f4a7c15ULL) >> 32U); }

  /// Looks up many keys, at most `most` of them new. The table is of no use to others meanwhile.
  class Lookups;

 private:
  static constexpr std::size_t kSmallest = std::size_t{1} << 15U;

  void reserve(std::size_t more) {
    while (2 * (voxels_.size() + more) > places_.size()) double_places();
    voxels_.reserve(voxels_.size() + more + 1);
  }

  void double_places() {
    places_.assign(2 * places_.size(), 0);
    for (std::size_t i = 0; i < voxels_.size(); ++i) {
      std::size_t place = hash(voxels_[i].key) & (places_.size() - 1);
      while (places_[place] != 0) place = (place + 1) & (places_.size() - 1);
      places_[place] = static_cast<std::uint32_t>(i + 1);
    }
  }

  std::vector<std::uint32_t> places_;  // slots, 0 where free
  VoxelList voxels_;
};

class VoxelTable::Lookups {
 public:
  Lookups(VoxelTable& table, std::size_t most) : table_(table) {
    table.reserve(most);
    places_ = table.places_.data();
    mask_ = table.places_.size() - 1;
    size_ = table.voxels_.size();
  }
  ~Lookups() { table_.voxels_.resize(size_); }
  Lookups(const Lookups&) = delete;
  Lookups& operator=(const Lookups&) = delete;

  // Both on the way to find_or_insert, the one long before the other: where the table is larger than the caches, many
  // look-ups wait for memory at the same time.
  void prefetch_place(std::uint32_t hash) const { __builtin_prefetch(&places_[hash & mask_]); }
  void prefetch_voxel(std::uint32_t hash) const {
    const std::uint32_t slot = places_[hash & mask_];
    __builtin_prefetch(&table_.voxels_[slot == 0 ? size_ : slot - 1]);
  }

  /// The key's slot; a new key gets the next one, its sums 0. Whether it is new decides no branch, which would be
  /// mispredicted for most of the new ones: a free place leads to the voxel after the last. 0.1 ms a frame.
  std::uint32_t find_or_insert(VoxelKey key, std::uint32_t hash) {
    const auto next = static_cast<std::uint32_t>(size_ + 1);
    table_.voxels_[size_] = {.key = key};
    std::size_t place = hash & mask_;
    while (true) {
      const std::uint32_t found = places_[place];
      const std::uint32_t slot = found == 0 ? next : found;
      if (table_.voxel(slot).key == key) {
        places_[place] = slot;
        size_ += static_cast<std::size_t>(found == 0);
        return slot;
      }
      place = (place + 1) & mask_;
    }
  }

 private:
  VoxelTable& table_;
  std::uint32_t* places_;
  std::size_t mask_, size_;
};

}  // namespace segserve
