#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "segserve/voxel/voxel_grid.hpp"

namespace segserve {

/// Open-addressing hash table from voxel keys to consecutive slots 1, 2, ..; load at most one half.
class VoxelTable {
 public:
  VoxelTable() { clear(); }

  void clear() {
    if (keys_.size() > kSmallest && keys_.size() > 16 * std::size_t{count_}) {
      keys_.resize(kSmallest);  // a small cloud after a large one must not pay for the large table
      slots_.resize(kSmallest);
    }
    keys_.assign(keys_.empty() ? kSmallest : keys_.size(), kFree);
    slots_.resize(keys_.size());
    count_ = 0;
  }

  std::uint32_t size() const { return count_; }

  /// The key's slot; a new key gets slot size() + 1.
  std::uint32_t find_or_insert(VoxelKey key) {
    std::size_t place = home(key);
    while (keys_[place] != key) {
      if (keys_[place] == kFree) {
        if (2 * (std::size_t{count_} + 1) > keys_.size()) {
          grow();
          return find_or_insert(key);
        }
        keys_[place] = key;
        return slots_[place] = ++count_;
      }
      place = (place + 1) & (keys_.size() - 1);
    }
    return slots_[place];
  }

 private:
  static constexpr VoxelKey kFree = ~VoxelKey{0};  // keys use 63 bits
  static constexpr std::size_t kSmallest = std::size_t{1} << 15U;

  std::size_t home(VoxelKey key) const {
    return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> 32U) & (keys_.size() - 1);
  }

  void grow() {
    std::vector<VoxelKey> old_keys(2 * keys_.size(), kFree);
    std::vector<std::uint32_t> old_slots(old_keys.size());
    old_keys.swap(keys_);
    old_slots.swap(slots_);
    for (std::size_t i = 0; i < old_keys.size(); ++i) {
      if (old_keys[i] == kFree) continue;
      std::size_t place = home(old_keys[i]);
      while (keys_[place] != kFree) place = (place + 1) & (keys_.size() - 1);
      keys_[place] = old_keys[i];
      slots_[place] = old_slots[i];
    }
  }

  std::vector<VoxelKey> keys_;
  std::vector<std::uint32_t> slots_;
  std::uint32_t count_ = 0;
};

}  // namespace segserve
