// SPDX-License-Identifier: Apache-2.0
#include "client/stream/service_time.hpp"

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using namespace std::chrono_literals;

TEST(ServiceTime, BoundsNothingBeforeTheFirstFrame) { EXPECT_EQ(ServiceTime().bound(), 0ns); }

TEST(ServiceTime, IsAboveTheMeanByTheSpread) {
  ServiceTime steady, changing;
  for (int i = 0; i < 100; ++i) {
    steady.add(100ms);
    changing.add(i % 2 == 0 ? 80ms : 120ms);
  }
  EXPECT_NEAR(static_cast<double>(steady.bound() / 1us), 100'000, 1'000);
  EXPECT_GT(changing.bound(), 150ms);
  EXPECT_LT(changing.bound(), 200ms);
}

TEST(ServiceTime, AFrameThatWasGivenUpMakesNothingSeemFaster) {
  ServiceTime time;
  for (int i = 0; i < 100; ++i) time.add(100ms);
  const auto before = time.bound();
  time.add_at_least(1ms);
  EXPECT_EQ(time.bound(), before);
  time.add_at_least(500ms);
  EXPECT_GT(time.bound(), before);
}

TEST(ServiceTime, FollowsAServerThatBecomesFaster) {
  ServiceTime time;
  for (int i = 0; i < 100; ++i) time.add(1s);
  for (int i = 0; i < 100; ++i) time.add(10ms);
  EXPECT_LT(time.bound(), 15ms);
}

}  // namespace
}  // namespace segserve::client
