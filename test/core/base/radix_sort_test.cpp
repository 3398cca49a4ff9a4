// SPDX-License-Identifier: Apache-2.0
#include "core/base/radix_sort.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace segserve::math {
namespace {

TEST(SortOrder, IsThatOfAStableSort) {
  std::mt19937_64 random(3);
  for (const std::uint64_t mask : {~0ULL, 0xffULL, 0xf000000000ffULL, 0ULL}) {
    std::vector<std::uint64_t> keys(1000);
    for (auto& key : keys) key = random() & mask;
    std::vector<std::uint32_t> expected(keys.size());
    std::iota(expected.begin(), expected.end(), 0U);
    std::ranges::stable_sort(expected, {}, [&](std::uint32_t i) { return keys[i]; });
    std::vector<std::uint32_t> order;
    sort_order(keys, order);
    EXPECT_EQ(order, expected);
  }
}

TEST(SortOrder, IsEmptyWithoutKeys) {
  std::vector<std::uint32_t> order{1, 2};
  sort_order({}, order);
  EXPECT_TRUE(order.empty());
}

}  // namespace
}  // namespace segserve::math
