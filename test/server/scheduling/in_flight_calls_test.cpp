// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/in_flight_calls.hpp"

#include <future>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST(InFlightCalls, CountsAdmittedCalls) {
  InFlightCalls calls;
  EXPECT_TRUE(calls.admit());
  EXPECT_TRUE(calls.admit());
  EXPECT_EQ(calls.count(), 2U);
  calls.release();
  EXPECT_EQ(calls.count(), 1U);
}

TEST(InFlightCalls, AdmitsNoneOnceClosed) {
  InFlightCalls calls;
  calls.close();
  EXPECT_FALSE(calls.admit());
  EXPECT_EQ(calls.count(), 0U);
}

TEST(InFlightCalls, WaitsUntilTheLastIsReleased) {
  InFlightCalls calls;
  ASSERT_TRUE(calls.admit());
  calls.close();
  EXPECT_FALSE(calls.wait_until_none_or(Clock::now() + 20ms));
  auto waiting = std::async(std::launch::async, [&calls] { calls.wait_until_none(); });
  EXPECT_EQ(waiting.wait_for(20ms), std::future_status::timeout);
  calls.release();
  EXPECT_EQ(waiting.wait_for(10s), std::future_status::ready);
  EXPECT_TRUE(calls.wait_until_none_or(Clock::now()));
}

}  // namespace
}  // namespace segserve::server
