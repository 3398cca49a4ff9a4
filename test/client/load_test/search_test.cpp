// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/search.hpp"

#include <cmath>
#include <random>

#include "gmock/gmock.h"

namespace segserve::bench {
namespace {

TEST(Search, FindsTheCapacityFromBelowAndFromAbove) {
  for (const double first : {1.0, 50.0, 99.0, 101.0, 5000.0}) {
    const auto found = find_capacity({.first = first}, [](double rate) { return rate <= 100; });
    ASSERT_TRUE(found.ok());
    EXPECT_LE(found->low, 100);
    EXPECT_GT(found->high, 100);
    EXPECT_LE(found->high, found->low * 1.03);
    EXPECT_LE(found->tries.size(), 25U) << first;
  }
}

TEST(Search, ALuckyTryDoesNotDecide) {
  // Rates near the capacity sometimes meet the objective and sometimes not.
  int far_off = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(100, 3);
    const auto found = find_capacity({.first = 40}, [&](double rate) { return rate <= noise(random); });
    if (std::abs(found->low - 100) > 5) ++far_off;
  }
  EXPECT_LE(far_off, 5);
}

TEST(Search, WithoutACapacityItEnds) {
  const auto none = find_capacity({.first = 100}, [](double) { return false; });
  EXPECT_EQ(none->low, 0);
  EXPECT_LT(none->tries.size(), 20U);
  const auto unbounded = find_capacity({.first = 100, .highest = 5000}, [](double) { return true; });
  EXPECT_EQ(unbounded->low, 5000);
  EXPECT_TRUE(std::isinf(unbounded->high));
}

TEST(Search, AnErrorEndsIt) {
  EXPECT_TRUE(absl::IsUnavailable(find_capacity({}, [](double) { return absl::UnavailableError("gone"); }).status()));
}

}  // namespace
}  // namespace segserve::bench
