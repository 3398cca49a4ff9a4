// SPDX-License-Identifier: Apache-2.0
#include "server/log/event_limiter.hpp"

#include <string>
#include <vector>

#include "fmt/format.h"
#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using std::chrono::seconds;

class EventLimiterTest : public testing::Test {
 protected:
  bool admit(const std::string& kind) { return limiter_.admit({.what = kind}, now_); }
  /// The events that are due, as "kind: count" in one line.
  std::string due() {
    std::string text;
    for (const auto& [kind, count] : limiter_.due(now_)) text += fmt::format("{}: {};", kind.what, count);
    return text;
  }

  EventLimiter limiter_{seconds(10), 3};
  EventLimiter::Time now_{seconds(1000)};
};

TEST_F(EventLimiterTest, LetsTheFirstOfEachKindThrough) {
  EXPECT_TRUE(admit("full"));
  EXPECT_FALSE(admit("full"));
  EXPECT_TRUE(admit("draining"));
  EXPECT_FALSE(admit("draining"));
}

TEST_F(EventLimiterTest, TellsKindsApartByAllTheirParts) {
  EventLimiter limiter(seconds(10));
  const std::vector<EventKind> kinds = {
      {"refused"}, {"refused", "A"}, {"refused", "A", "B"}, {"refused", "A", "C"}, {"refused", "A", "B", "limit"}};
  for (const EventKind& kind : kinds) EXPECT_TRUE(limiter.admit(kind, now_));
  for (const EventKind& kind : kinds) EXPECT_FALSE(limiter.admit(kind, now_));
}

TEST_F(EventLimiterTest, CountsTheOthersOfAPeriod) {
  for (int i = 0; i < 533; ++i) admit("full");
  EXPECT_EQ(due(), "");
  now_ += seconds(10);
  EXPECT_EQ(due(), "full: 532;");
  EXPECT_EQ(due(), "");
}

TEST_F(EventLimiterTest, GoesOnCountingWhileAFloodLasts) {
  for (int period = 0; period < 5; ++period) {
    EXPECT_EQ(admit("full"), period == 0);
    admit("full");
    now_ += seconds(10);
    EXPECT_EQ(due(), period == 0 ? "full: 1;" : "full: 2;");
  }
}

TEST_F(EventLimiterTest, LosesNoEventBetweenAPeriodAndItsSummary) {
  admit("full");
  now_ += seconds(11);
  EXPECT_FALSE(admit("full"));
  EXPECT_EQ(due(), "full: 1;");
}

TEST_F(EventLimiterTest, TakesAnEventForAFirstOneAfterAQuietPeriod) {
  admit("full");
  now_ += seconds(10);
  EXPECT_EQ(due(), "");
  EXPECT_TRUE(admit("full"));
}

TEST_F(EventLimiterTest, KnowsABoundedNumberOfKinds) {
  for (int i = 0; i < 1000; ++i) admit(fmt::format("kind {}", i));
  now_ += seconds(10);
  EXPECT_EQ(due(), "others: 997;");
}

TEST_F(EventLimiterTest, TellsTheRestAtTheEnd) {
  for (int i = 0; i < 4; ++i) admit("full");
  const auto rest = limiter_.rest();
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(rest.front().count, 3U);
}

}  // namespace
}  // namespace segserve::server
