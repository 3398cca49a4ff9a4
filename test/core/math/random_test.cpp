// SPDX-License-Identifier: Apache-2.0
#include "core/math/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace segserve {
namespace {

// Reference values of SplitMix64 with seed 0 (Vigna's splitmix64.c): its n-th output is
// mix(n * golden ratio).
TEST(RandomTest, MixIsSplitMix64) {
  EXPECT_EQ(mix(0), 0xE220A8397B1DCDAFU);
  EXPECT_EQ(mix(0x9E3779B97F4A7C15U), 0x6E789E6AA1B965F4U);
}

TEST(RandomTest, GaussianHasMeanZeroVarianceOneAndNormalTails) {
  Random random(7);
  constexpr int kDraws = 200000;
  double sum = 0, squares = 0;
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.gaussian();
    sum += value;
    squares += value * value;
    beyond_two += std::abs(value) > 2 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.01);
  EXPECT_NEAR(squares / kDraws, 1, 0.01);
  EXPECT_NEAR(static_cast<double>(beyond_two) / kDraws, 0.0455, 0.004);
}

TEST(RandomTest, BelowReachesEveryValueAndNoOther) {
  Random random(1);
  int count[5] = {};
  for (int i = 0; i < 5000; ++i) {
    const std::uint32_t value = random.below(5);
    ASSERT_LT(value, 5U);
    ++count[value];
  }
  for (const int c : count) EXPECT_NEAR(c, 1000, 150);
}

}  // namespace
}  // namespace segserve
