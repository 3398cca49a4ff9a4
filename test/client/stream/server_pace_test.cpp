// SPDX-License-Identifier: Apache-2.0
#include "client/stream/server_pace.hpp"

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(ServerPace, AmongOthersASlowServerGetsAnotherChance) {
  Time now{std::chrono::hours(1)};
  ServerPace pace;
  pace.set_one_of_several(true);
  EXPECT_EQ(pace.expected(now), milliseconds(0));
  pace.add(milliseconds(2000), now);
  EXPECT_EQ(pace.expected(now), milliseconds(2000));
  now += seconds(30);
  EXPECT_LT(pace.expected(now), milliseconds(3));
  pace.add(milliseconds(20), now);
  EXPECT_LT(pace.expected(now), milliseconds(30)) << "what is old counts little";
}

TEST(ServerPace, TheOnlyServersPaceIsLearnedAsTcpDoes) {
  Time now{std::chrono::hours(1)};
  ServerPace pace;
  pace.add(milliseconds(800), now);
  now += seconds(30);
  EXPECT_EQ(pace.expected(now), milliseconds(800));
  pace.add(milliseconds(0), now);
  EXPECT_EQ(pace.expected(now), milliseconds(700));
}

}  // namespace
}  // namespace segserve::client
