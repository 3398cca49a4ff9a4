// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxel_table.hpp"

#include <gtest/gtest.h>

#include <unordered_map>

#include "core/math/random.hpp"

namespace segserve {
namespace {

VoxelKey key_at(std::uint64_t x, std::uint64_t y, std::uint64_t z) { return x | y << kCellBits | z << (2 * kCellBits); }

std::vector<VoxelKey> block_of_cells(std::uint64_t edge) {
  std::vector<VoxelKey> keys;
  for (std::uint64_t z = 0; z < edge; ++z) {
    for (std::uint64_t y = 0; y < edge; ++y) {
      for (std::uint64_t x = 0; x < edge; ++x) keys.push_back(key_at(kCellBias + x, 1021 + y, kCellBias - 3 + z));
    }
  }
  return keys;
}

/// Random keys in groups of 40 that are close to each other.
std::vector<VoxelKey> random_keys(std::size_t count) {
  Random random(7);
  std::vector<VoxelKey> keys;
  while (keys.size() < count) {
    const VoxelKey middle = random.bits() & ~(VoxelKey{1} << 63U) & ~key_at(31, 31, 31);
    for (int i = 0; i < 40; ++i) keys.push_back(middle | (random.bits() & key_at(31, 31, 31)));
  }
  return keys;
}

void expect_slots_in_order_of_appearance(VoxelTable& table, const std::vector<VoxelKey>& keys) {
  std::unordered_map<VoxelKey, std::uint32_t> expected;
  for (std::size_t first = 0; first < keys.size(); first += 500) {
    const std::size_t last = std::min(first + 500, keys.size());
    VoxelTable::Lookups lookups(table, last - first);
    for (std::size_t i = first; i < last; ++i) {
      const auto next = static_cast<std::uint32_t>(expected.size() + 1);
      const std::uint32_t slot = lookups.find_or_insert(keys[i]);
      ASSERT_EQ(slot, expected.try_emplace(keys[i], next).first->second) << "key " << i;
      table.voxel(slot).points += 1;
    }
  }
  ASSERT_EQ(table.voxels().size(), expected.size());
  std::uint64_t points = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(expected[table.voxels()[i].key], i + 1);
    points += table.voxels()[i].points;
  }
  EXPECT_EQ(points, keys.size());
}

TEST(VoxelTable, TellsAllCellsOfABlockApart) {
  VoxelTable table;
  std::vector<VoxelKey> keys = block_of_cells(9);
  keys.insert(keys.end(), keys.begin(), keys.end());
  expect_slots_in_order_of_appearance(table, keys);
}

TEST(VoxelTable, GrowsWithoutLosingVoxels) {
  VoxelTable table;
  expect_slots_in_order_of_appearance(table, random_keys(200'000));
}

TEST(VoxelTable, StartsAnewAfterAnotherCloud) {
  VoxelTable table;
  for (const std::size_t count : {100'000, 40, 50'000}) {
    table.clear();
    expect_slots_in_order_of_appearance(table, random_keys(count));
  }
}

TEST(VoxelTable, FindsAsManyAgainAfterAScatteredCloud) {
  std::vector<VoxelKey> scattered;
  for (std::uint64_t i = 0; i < 20'000; ++i) scattered.push_back(key_at(5 * i, 0, 9 * i));
  VoxelTable table;
  for (int cloud = 0; cloud < 2; ++cloud) {
    expect_slots_in_order_of_appearance(table, scattered);
    table.free_if_scattered();
    EXPECT_EQ(table.voxels().size(), 0U);
  }
}

TEST(VoxelTable, KeepsADenseCloud) {
  VoxelTable table;
  expect_slots_in_order_of_appearance(table, block_of_cells(20));
  table.free_if_scattered();
  EXPECT_EQ(table.voxels().size(), 8000U);
}

}  // namespace
}  // namespace segserve
