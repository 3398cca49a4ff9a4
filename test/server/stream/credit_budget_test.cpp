// SPDX-License-Identifier: Apache-2.0
#include "server/stream/credit_budget.hpp"

#include <utility>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

constexpr CreditLimits kLimits{
    .most_per_stream = {.frames = 4, .bytes = 1000}, .default_bytes_per_stream = 300, .bytes_of_all_streams = 2000};

TEST(CreditBudget, GivesWhatIsWantedWithinTheLimitsOfAStream) {
  CreditBudget budget(kLimits);
  EXPECT_EQ(budget.reserve({})->credit(), (Credit{.frames = 4, .bytes = 300}));
  EXPECT_EQ(budget.reserve({.frames = 2, .bytes = 50})->credit(), (Credit{.frames = 2, .bytes = 50}));
  EXPECT_EQ(budget.reserve({.frames = 9, .bytes = 5000})->credit(), (Credit{.frames = 4, .bytes = 1000}));
  EXPECT_EQ(budget.free_bytes(), 2000U) << "the reservations have ended";
}

TEST(CreditBudget, NeverGivesMoreThanItHas) {
  CreditBudget budget(kLimits);
  const auto first = budget.reserve({.frames = 1, .bytes = 1000});
  const auto second = budget.reserve({.frames = 1, .bytes = 900});
  const auto rest = budget.reserve({.frames = 1, .bytes = 1000});
  ASSERT_TRUE(first && second && rest);
  EXPECT_EQ(rest->credit().bytes, 100U);
  EXPECT_FALSE(budget.reserve({.frames = 1, .bytes = 16}));
}

TEST(CreditBudget, PrefersNoneToATrickle) {
  CreditBudget budget(kLimits);
  const auto first = budget.reserve({.frames = 1, .bytes = 1000});
  const auto second = budget.reserve({.frames = 1, .bytes = 950});
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(budget.reserve({.frames = 1, .bytes = 1000})) << "50 bytes are less than a 16th";
  EXPECT_TRUE(budget.reserve({.frames = 1, .bytes = 800}));
}

TEST(CreditBudget, AReservationMovesAndEndsOnce) {
  CreditBudget budget(kLimits);
  {
    auto first = budget.reserve({.frames = 1, .bytes = 100});
    CreditBudget::Reservation moved = *std::move(first);
    EXPECT_EQ(budget.free_bytes(), 1900U);
    CreditBudget::Reservation other = *budget.reserve({.frames = 1, .bytes = 200});
    other = std::move(moved);
    EXPECT_EQ(budget.free_bytes(), 1900U) << "the 200 are back";
    other.release();
    other.release();
    EXPECT_EQ(budget.free_bytes(), 2000U);
  }
  EXPECT_EQ(budget.free_bytes(), 2000U);
}

}  // namespace
}  // namespace segserve::server
