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

/// Items in blocks, so that they never move: for those who grow by millions, no copies and no second place to copy to.
template <typename T, std::size_t kBlock>
class BlockList {
 public:
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return blocks_[i / kBlock][i % kBlock]; }
  T& operator[](std::size_t i) { return blocks_[i / kBlock][i % kBlock]; }

  /// Room for so many; what stands there is no item until `resize` says so.
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

/// Cells of 4 x 4 x 4, and the slots of their voxels; 0 where there is none.
struct Cube {
  std::array<std::uint32_t, 64> slots;

  static constexpr VoxelKey kInside = VoxelKey{3} | VoxelKey{3} << kCellBits | VoxelKey{3} << (2 * kCellBits);

  /// The key of its first cell names a cube.
  static VoxelKey of(VoxelKey key) { return key & ~kInside; }
  std::uint32_t& slot(VoxelKey key) {
    return slots[(key & 3U) | (key >> (kCellBits - 2) & 12U) | (key >> (2 * kCellBits - 4) & 48U)];
  }
};

/// From voxel keys to consecutive slots 1, 2, ..: an open-addressing hash table of cubes, load at most one half. Points
/// next to each other lie in the same few cubes, so that large clouds find them in the caches: 262 -> 173 ms of 10
/// million points. And a cell needs no search, in which what comes next can hardly be predicted.
class VoxelTable {
 public:
  VoxelTable() { clear(); }

  void clear() {
    if (places_.size() > 16 * cubes_.size()) places_.clear();  // a small cloud after a large one must not pay for it
    set_places(std::max(places_.size(), kFewest));
    cubes_.resize(0);
    voxels_.resize(0);
  }

  /// Clears it of a scattered cloud, whose cubes take more memory than its voxels, and gives that back.
  void free_if_scattered() {
    if (cubes_.size() * sizeof(Cube) <= voxels_.size() * sizeof(VoxelSums)) return;
    clear();
    cubes_.free();
    voxels_.free();
  }

  /// In the order of their slots.
  const VoxelList& voxels() const { return voxels_; }
  VoxelSums& voxel(std::uint32_t slot) { return voxels_[slot - 1]; }

  static std::uint32_t hash(VoxelKey key) {
    return static_cast<std::uint32_t>((Cube::of(key) * 0x9e3779b97f4a7c15ULL) >> 32U);
  }

  /// Looks up many keys, at most `most` of them new. The table is of no use to others meanwhile.
  class Lookups;

 private:
  static constexpr std::size_t kFewest = std::size_t{1} << 13U;

  struct Place {
    VoxelKey key = 0;      // of the cube
    Cube* cube = nullptr;  // null: free
  };

  void set_places(std::size_t count) {
    places_.assign(count, Place{});
    shift_ = 32 - std::countr_zero(count);
  }

  /// An empty one, and a place for it.
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

  /// The place of a cube, or the free one that it shall have.
  Place& find(VoxelKey cube, std::uint32_t hash) {
    std::size_t place = hash >> shift_;
    while (places_[place].key != cube && places_[place].cube != nullptr) place = (place + 1) & (places_.size() - 1);
    return places_[place];
  }

  std::vector<Place> places_;
  int shift_ = 0;  // of a hash: what is left of it is the place to start from
  BlockList<Cube, std::size_t{1} << 9U> cubes_;
  VoxelList voxels_;
};

class VoxelTable::Lookups {
 public:
  Lookups(VoxelTable& table, std::size_t most) : table_(table) {
    size_ = table.voxels_.size();
    table.voxels_.reserve(size_ + most + 1);
  }
  ~Lookups() { table_.voxels_.resize(size_); }
  Lookups(const Lookups&) = delete;
  Lookups& operator=(const Lookups&) = delete;

  // A look-up has three steps, for many keys one step after the other: each asks the memory for what the next one
  // needs, and large clouds have many look-ups wait at the same time.

  void prefetch(std::uint32_t hash) const { __builtin_prefetch(&table_.places_[hash >> table_.shift_]); }

  std::uint32_t* find_cell(VoxelKey key, std::uint32_t hash) {
    const Place& place = table_.find(Cube::of(key), hash);
    Cube& cube = place.cube != nullptr ? *place.cube : table_.add_cube(Cube::of(key), hash);
    std::uint32_t* const cell = &cube.slot(key);
    __builtin_prefetch(cell);
    return cell;
  }

  /// The slot of a key in its cell; a new key gets the next one, its sums 0. Whether it is new decides no branch, which
  /// would be mispredicted for most of the new ones: an empty cell leads to the voxel after the last. 0.1 ms a frame.
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
