// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/server_name.hpp"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using testing::ElementsAre;

TEST(Addresses, AreSeparatedByCommas) {
  EXPECT_THAT(*parse_addresses("a:1"), ElementsAre("a:1"));
  EXPECT_THAT(*parse_addresses(" a:1, dns:///b:2 ,unix:/c"), ElementsAre("a:1", "dns:///b:2", "unix:/c"));
  for (const char* wrong : {"", " ", ",", "a:1,", "a:1,,b:2"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(parse_addresses(wrong).status())) << wrong;
  }
}

TEST(Addresses, WithoutAPortHaveTheDefaultOne) {
  EXPECT_THAT(*parse_addresses("robot,10.0.0.7,[::1],fe80::1"),
              ElementsAre("robot:50051", "10.0.0.7:50051", "[::1]:50051", "[fe80::1]:50051"));
  EXPECT_THAT(*parse_addresses("[::1]:7"), ElementsAre("[::1]:7"));
}

TEST(Addresses, UrlsAndPortsThatAreNoneAreRefused) {
  for (const char* wrong : {"http://robot:50051", "grpc://robot", "robot:50051/v1", "robot:", "robot:port", "robot:0",
                            "robot:65536", "robot:-1"}) {
    const absl::Status status = parse_addresses(wrong).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << wrong;
    EXPECT_NE(status.message().find(wrong), std::string::npos) << status;
  }
}

TEST(Addresses, NamesAreLookedUpHere) {
  EXPECT_EQ(name_to_look_up("robot:7"), (HostName{"robot", "7"}));
  EXPECT_EQ(name_to_look_up("127.example.com:7"), (HostName{"127.example.com", "7"}));
  EXPECT_EQ(name_to_look_up("dns:///robot:7"), (HostName{"robot", "7"}));
  EXPECT_EQ(name_to_look_up("dns:robot"), (HostName{"robot", "50051"}));
}

TEST(Addresses, OfOneServerAreLeftAsTheyAre) {
  for (const char* address :
       {"10.0.0.7:50051", "[::1]:50051", "localhost:50051", "unix:/run/x", "ipv4:10.0.0.7:1", "dns:///10.0.0.7:50051",
        "dns:///[::1]:50051", "dns://10.0.0.1/robot:50051", "xds:///robot"}) {
    EXPECT_FALSE(name_to_look_up(address).has_value()) << address;
  }
}

}  // namespace
}  // namespace segserve::client
