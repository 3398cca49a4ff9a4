// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/client_address.hpp"

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

TEST(ClientAddress, LeavesThePortOut) {
  EXPECT_EQ(client_address("ipv4:192.0.2.7:40312"), "ipv4:192.0.2.7");
  EXPECT_EQ(client_address("unix:"), "unix");
  EXPECT_EQ(client_address("unix:/run/s"), "unix");
}

TEST(ClientAddress, Ipv4IsTheSameWithinIpv6) {
  EXPECT_EQ(client_address("ipv6:%5B::ffff:192.0.2.7%5D:40312"), "ipv4:192.0.2.7");
}

TEST(ClientAddress, ANetworkOfIpv6IsOneClient) {
  const std::string network = client_address("ipv6:%5B2001:db8:1:2:3:4:5:6%5D:40312");
  EXPECT_EQ(client_address("ipv6:%5B2001:db8:1:2::9%5D:7"), network);
  EXPECT_EQ(client_address("ipv6:[2001:db8:1:2:ffff::1]:7"), network);
  EXPECT_NE(client_address("ipv6:%5B2001:db8:1:3::9%5D:7"), network);
  EXPECT_NE(client_address("ipv6:%5B::1%5D:7"), network);
}

}  // namespace
}  // namespace segserve::server
