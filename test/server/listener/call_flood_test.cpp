// SPDX-License-Identifier: Apache-2.0
#include "server/listener/call_flood.hpp"

#include <array>
#include <chrono>
#include <cstddef>

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr CallFlood::Limits kLimits{.calls = 2, .excess = 3, .rate = 6, .waiting = 4, .rate_in_need = 2, .few = 1};
constexpr const char* kPeer = "ipv4:192.0.2.7:1000";
constexpr const char* kNeighbor = "ipv4:192.0.2.7:1001";
constexpr const char* kOther = "ipv4:198.51.100.1:1000";

class CallFloodTest : public testing::Test {
 protected:
  /// A call arrives and begins; true if its connection floods the server.
  bool begin(const char* peer) {
    flood.on_arrival();
    return flood.on_begin(&calls[count++], peer, now);
  }
  void end(std::size_t call) { flood.on_end(&calls[call]); }

  CallFlood flood{kLimits};
  CallFlood::Time now{seconds(100)};
  std::array<char, 100> calls{};
  std::size_t count = 0;
};

TEST_F(CallFloodTest, CallsThatEndAreNoFlood) {
  for (std::size_t i = 0; i < 50; ++i, now += milliseconds(200)) {
    EXPECT_FALSE(begin(kPeer));
    end(i);
  }
  EXPECT_FALSE(flood.is_held("ipv4:192.0.2.7", now));
}

TEST_F(CallFloodTest, TooManyCallsInASecondAre) {
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_FALSE(begin(kPeer));
    end(i);
  }
  EXPECT_TRUE(begin(kPeer));
  EXPECT_FALSE(begin(kOther));
  EXPECT_TRUE(flood.is_held("ipv4:192.0.2.7", now + milliseconds(999)));
  EXPECT_FALSE(flood.is_held("ipv4:192.0.2.7", now + milliseconds(1000)));
  EXPECT_FALSE(flood.is_held("ipv4:198.51.100.1", now));
  now += seconds(1);
  EXPECT_FALSE(begin(kPeer)) << "a new second has begun";
  EXPECT_FALSE(begin(kPeer));
  EXPECT_TRUE(begin(kPeer)) << "the address is on probation";
}

TEST_F(CallFloodTest, TheCallsOfAllConnectionsOfAnAddressCount) {
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_FALSE(begin(kPeer));
    end(i);
  }
  EXPECT_FALSE(begin(kNeighbor)) << "a single call has no part in the flood";
  EXPECT_TRUE(begin(kNeighbor));
}

TEST_F(CallFloodTest, MoreCallsAtATimeThanConnectionsMayHaveAre) {
  for (int i = 0; i < 4; ++i, now += seconds(1)) EXPECT_FALSE(begin(kPeer));
  EXPECT_FALSE(begin(kNeighbor)) << "it has no call in excess";
  EXPECT_FALSE(begin(kPeer)) << "the third in excess";
  EXPECT_TRUE(begin(kPeer));
  now += seconds(1);
  for (std::size_t i = 0; i < 4; ++i) end(i);
  EXPECT_FALSE(begin(kPeer));
}

TEST_F(CallFloodTest, TheCallsInExcessOfAllConnectionsOfAnAddressCount) {
  for (const char* peer : {kPeer, kNeighbor}) {
    for (int i = 0; i < 3; ++i) EXPECT_FALSE(begin(peer));
    now += seconds(1);
  }
  EXPECT_FALSE(begin(kPeer)) << "the third in excess";
  EXPECT_TRUE(begin(kNeighbor));
}

TEST_F(CallFloodTest, FewerCallsInASecondAreOneWhileManyWait) {
  for (int i = 0; i < 5; ++i) flood.on_arrival();
  EXPECT_FALSE(begin(kPeer));
  EXPECT_FALSE(begin(kPeer));
  EXPECT_TRUE(begin(kPeer));
  const char never_begun = 0;
  flood.on_end(&never_begun);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(begin(kOther)) << "four wait, which are not many";
}

}  // namespace
}  // namespace segserve::server
