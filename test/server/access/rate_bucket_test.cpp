// SPDX-License-Identifier: Apache-2.0
#include "server/access/rate_bucket.hpp"

#include <limits>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;

const RateBucket::Time kFilled{1000s};

TEST(RateBucket, HoldsWhatOneSecondBrings) {
  RateBucket bucket(10, kFilled);
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(bucket.wait_for(1, kFilled), 0ms) << i;
    bucket.take(1);
  }
  EXPECT_EQ(bucket.wait_for(1, kFilled), 100ms);
  EXPECT_EQ(bucket.wait_for(1, kFilled + 40ms), 60ms);
  EXPECT_EQ(bucket.wait_for(3, kFilled + 100ms), 200ms);
  EXPECT_EQ(bucket.wait_for(1, kFilled + 100ms), 0ms);
  EXPECT_EQ(bucket.wait_for(10, kFilled + 1h), 0ms);
  bucket.take(10);
  EXPECT_EQ(bucket.wait_for(1, kFilled + 1h), 100ms) << "an hour brings no more than a second";
}

TEST(RateBucket, HoldsAtLeastOne) {
  RateBucket bucket(0.1, kFilled);
  EXPECT_EQ(bucket.wait_for(1, kFilled), 0ms);
  bucket.take(1);
  EXPECT_EQ(bucket.wait_for(1, kFilled), 10s);
  EXPECT_EQ(bucket.wait_for(1, kFilled + 10s), 0ms);
}

TEST(RateBucket, GivesMoreThanItHoldsWhenItIsFull) {
  RateBucket bucket(1000, kFilled);
  EXPECT_EQ(bucket.wait_for(5000, kFilled), 0ms);
  bucket.take(5000);
  EXPECT_EQ(bucket.wait_for(1, kFilled + 4s), 1ms) << "the debt is paid after four seconds";
  EXPECT_EQ(bucket.wait_for(5000, kFilled + 4s), 1000ms);
  EXPECT_FALSE(bucket.is_full(kFilled + 4s));
  EXPECT_TRUE(bucket.is_full(kFilled + 5s));
}

TEST(RateBucket, LetsThoseWhoWaitComeBackOneAfterTheOther) {
  RateBucket bucket(4, kFilled);
  bucket.take(4);
  for (const int wait : {250, 500, 750, 1000, 250}) EXPECT_EQ(bucket.wait_in_line(1, kFilled), wait * 1ms);
  bucket.take(1);
  EXPECT_EQ(bucket.wait_in_line(1, kFilled), 500ms) << "the first in a new line";
}

TEST(RateBucket, TakesBack) {
  RateBucket bucket(2, kFilled);
  bucket.take(2);
  bucket.give_back(1);
  EXPECT_EQ(bucket.wait_for(1, kFilled), 0ms);
  bucket.give_back(100);
  bucket.take(2);
  EXPECT_EQ(bucket.wait_for(1, kFilled), 500ms);
}

TEST(RateBucket, ChangesItsRate) {
  RateBucket bucket(100, kFilled);
  bucket.take(50);
  bucket.set_rate(10, kFilled);
  bucket.take(10);
  EXPECT_EQ(bucket.wait_for(1, kFilled), 100ms);
  bucket.set_rate(1000, kFilled + 100ms);
  EXPECT_EQ(bucket.wait_for(2, kFilled + 100ms), 1ms);
}

TEST(RateBucket, MayHaveNoBound) {
  RateBucket bucket(std::numeric_limits<double>::infinity(), kFilled);
  bucket.take(1e18);
  EXPECT_EQ(bucket.wait_for(1e18, kFilled), 0ms);
  EXPECT_TRUE(bucket.is_full(kFilled));
  bucket.set_rate(10, kFilled + 1s);
  EXPECT_EQ(bucket.wait_for(10, kFilled + 1s), 0ms) << "it begins full";
}

}  // namespace
}  // namespace segserve::server
