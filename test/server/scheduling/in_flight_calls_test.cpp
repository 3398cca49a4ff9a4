#include "server/scheduling/in_flight_calls.hpp"

#include <future>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST(InFlightCalls, CountsWhoIsIn) {
  InFlightCalls gate;
  EXPECT_TRUE(gate.enter());
  EXPECT_TRUE(gate.enter());
  EXPECT_EQ(gate.inside(), 2U);
  gate.leave();
  EXPECT_EQ(gate.inside(), 1U);
}

TEST(InFlightCalls, LetsNobodyInOnceClosed) {
  InFlightCalls gate;
  gate.close();
  EXPECT_FALSE(gate.enter());
  EXPECT_EQ(gate.inside(), 0U);
}

TEST(InFlightCalls, WaitsForTheLastToLeave) {
  InFlightCalls gate;
  ASSERT_TRUE(gate.enter());
  gate.close();
  EXPECT_FALSE(gate.wait_until_empty_or(Clock::now() + 20ms));
  auto waiting = std::async(std::launch::async, [&gate] { gate.wait_until_empty(); });
  EXPECT_EQ(waiting.wait_for(20ms), std::future_status::timeout);
  gate.leave();
  EXPECT_EQ(waiting.wait_for(10s), std::future_status::ready);
  EXPECT_TRUE(gate.wait_until_empty_or(Clock::now()));
}

}  // namespace
}  // namespace segserve::server
