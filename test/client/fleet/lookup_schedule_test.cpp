// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/lookup_schedule.hpp"

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::seconds;

class LookupScheduleTest : public testing::Test {
 protected:
  /// Seconds from now until the next lookup.
  double wait() const { return std::chrono::duration<double>(*schedule_.due() - now_).count(); }
  void answer(bool is_news) { schedule_.on_answer(is_news, now_); }

  Time now_{std::chrono::hours(1)};
  LookupSchedule schedule_{1};
};

TEST_F(LookupScheduleTest, TheFirstLookupIsAtOnce) { EXPECT_FALSE(schedule_.due().has_value()); }

TEST_F(LookupScheduleTest, ItIsRareWhileNothingHappens) {
  answer(false);
  EXPECT_GE(wait(), 8);
  EXPECT_LE(wait(), 10);
}

TEST_F(LookupScheduleTest, AfterNewsItIsFrequentForAWhile) {
  answer(true);
  for (int i = 0; i < 5; ++i) {
    EXPECT_GE(wait(), 1.6);
    EXPECT_LE(wait(), 2);
    now_ += seconds(2);
    answer(false);
  }
  EXPECT_GE(wait(), 8);
}

TEST_F(LookupScheduleTest, TroubleMakesTheNextLookupDueEarlier) {
  answer(false);
  now_ += seconds(5);
  schedule_.on_trouble(now_);
  EXPECT_LE(wait(), 0) << "the last lookup is longer ago than two seconds";
  answer(false);
  EXPECT_LE(wait(), 2);
  now_ += seconds(11);
  answer(false);
  EXPECT_GE(wait(), 8);
}

}  // namespace
}  // namespace segserve::client
