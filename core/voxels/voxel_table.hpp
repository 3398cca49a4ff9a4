// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/voxels/simd/voxel_kernels.hpp"
#include "core/voxels/voxel_key.hpp"

namespace segserve {

/// A voxel and integer sums over its points. Integer sums are exact, so the order of the points does not matter. It
/// takes one cache line.
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

  /// Adds `count` points, whose sums are the difference of two running sums.
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

/// A list whose items are in blocks and never move. Lists of millions of items grow without copies, and without a
/// second place to copy to.
template <typename T, std::size_t kBlock>
class BlockList {
 public:
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return blocks_[i / kBlock][i % kBlock]; }
  T& operator[](std::size_t i) { return blocks_[i / kBlock][i % kBlock]; }

  /// Makes room for `count` items, which are items of the list only once `resize` says so.
  void reserve(std::size_t count) {
    while (blocks_.size() * kBlock < count) blocks_.push_back(std::make_unique_for_overwrite<T[]>(kBlock));
  }
  void resize(std::size_t size) { size_ = size; }
  void free() { *this = BlockList(); }

 private:
  std::vector<std::unique_ptr<T[]>> blocks_;
  std::size_t size_ = 0;
};

using VoxelList = BlockList<VoxelSums, std::size_t{1} << 13U>;

/// A cube of 4 x 4 x 4 cells with the slots of their voxels, or 0 for cells without a voxel.
struct Cube {
  std::array<std::uint32_t, 64> slots;

  static constexpr VoxelKey kInside = VoxelKey{3} | VoxelKey{3} << kCellBits | VoxelKey{3} << (2 * kCellBits);

  /// The cube of a cell; the key of its first cell names a cube.
  static VoxelKey of(VoxelKey key) { return key & ~kInside; }
  std::uint32_t& slot(VoxelKey key) {
    return slots[(key & 3U) | (key >> (kCellBits - 2) & 12U) | (key >> (2 * kCellBits - 4) & 48U)];
  }
};

/// Maps voxel keys to consecutive slots from 1 on. It is an open-addressing hash table of cubes with a load of at most
/// one half. Points next to each other lie in the same few cubes, so the caches hold what the points of a large cloud
/// need. Within a cube the slot of a cell is found without a search, whose branches could hardly be predicted.
class VoxelTable {
 public:
  VoxelTable() { clear(); }

  void clear() {
    if (places_.size() > 16 * cubes_.size())
      places_.clear();  // Small clouds after a large one must not pay for its places.
    set_places(std::max(places_.size(), kFewest));
    cubes_.resize(0);
    voxels_.resize(0);
  }

  /// Clears the table and gives its memory back if the cloud is scattered, so that cubes take more memory than voxels.
  void free_if_scattered() {
    if (cubes_.size() * sizeof(Cube) <= voxels_.size() * sizeof(VoxelSums)) return;
    clear();
    cubes_.free();
    voxels_.free();
  }

  /// The voxels in the order of their slots.
  const VoxelList& voxels() const { return voxels_; }
  VoxelSums& voxel(std::uint32_t slot) { return voxels_[slot - 1]; }

  static std::uint32_t hash(VoxelKey key) {
    return static_cast<std::uint32_t>((Cube::of(key) * 0x9e3779b97f4a7c15ULL) >> 32U);
  }

  /// Looks up many keys. Nothing else may use the table in the meantime.
  class Lookups;

 private:
  static constexpr std::size_t kFewest = std::size_t{1} << 13U;

  struct Place {
    VoxelKey key = 0;      // of the cube
    Cube* cube = nullptr;  // null if the place is free
  };

  void set_places(std::size_t count) {
    places_.assign(count, Place{});
    shift_ = 32 - std::countr_zero(count);
  }

  /// Adds an empty cube, and finds a place for it.
  __attribute__((noinline)) Cube& add_cube(VoxelKey key, std::uint32_t hash) {
    if (2 * (cubes_.size() + 1) > places_.size()) double_places();
    cubes_.reserve(cubes_.size() + 1);
    cubes_.resize(cubes_.size() + 1);
    Cube& cube = cubes_[cubes_.size() - 1];
    cube.slots.fill(0);
    find(key, hash) = {key, &cube};
    return cube;
  }

  void double_places() {
    const std::vector<Place> old = std::move(places_);
    set_places(2 * old.size());
    for (const Place& place : old) {
      if (place.cube != nullptr) find(place.key, hash(place.key)) = place;
    }
  }

  /// The place of a cube, or the free place where it belongs.
  Place& find(VoxelKey cube, std::uint32_t hash) {
    std::size_t place = hash >> shift_;
    while (places_[place].key != cube && places_[place].cube != nullptr) place = (place + 1) & (places_.size() - 1);
    return places_[place];
  }

  std::vector<Place> places_;
  int shift_ = 0;  // A hash shifted by this is the place where a search starts.
  BlockList<Cube, std::size_t{1} << 9U> cubes_;
  VoxelList voxels_;
};

class VoxelTable::Lookups {
 public:
  /// At most `most` of the keys may be new.
  Lookups(VoxelTable& table, std::size_t most) : table_(table) {
    size_ = table.voxels_.size();
    table.voxels_.reserve(size_ + most + 1);
  }
  ~Lookups() { table_.voxels_.resize(size_); }
  Lookups(const Lookups&) = delete;
  Lookups& operator=(const Lookups&) = delete;

  // A look-up has three steps: prefetch, find_cell and find_or_insert. Callers do each step for many keys before the
  // next step. Each step asks the memory for what the next one needs, so that many keys wait for it at the same time.

  void prefetch(std::uint32_t hash) const { __builtin_prefetch(&table_.places_[hash >> table_.shift_]); }

  std::uint32_t* find_cell(VoxelKey key, std::uint32_t hash) {
    const Place& place = table_.find(Cube::of(key), hash);
    Cube& cube = place.cube != nullptr ? *place.cube : table_.add_cube(Cube::of(key), hash);
    std::uint32_t* const cell = &cube.slot(key);
    __builtin_prefetch(cell);
    return cell;
  }

  /// The slot of a key in its cell. A new key gets the next slot, with sums of 0. No branch asks whether the key is
  /// new, because it would be mispredicted for most new keys: an empty cell leads to the voxel after the last.
  std::uint32_t find_or_insert(VoxelKey key, std::uint32_t* cell) {
    table_.voxels_[size_] = {.key = key};
    const bool is_new = *cell == 0;
    const std::uint32_t slot = is_new ? static_cast<std::uint32_t>(size_ + 1) : *cell;
    *cell = slot;
    size_ += static_cast<std::size_t>(is_new);
    __builtin_prefetch(&table_.voxels_[slot - 1]);
    return slot;
  }

  std::uint32_t find_or_insert(VoxelKey key) { return find_or_insert(key, find_cell(key, hash(key))); }

 private:
  VoxelTable& table_;
  std::size_t size_;
};

}  // namespace segserve
