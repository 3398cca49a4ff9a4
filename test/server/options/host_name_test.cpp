// SPDX-License-Identifier: Apache-2.0
#include "server/options/host_name.hpp"

#include <gmock/gmock.h>

namespace segserve::server {
namespace {

using testing::ElementsAre;

TEST(HostName, ThisMachineIsAllowed) {
  for (const char* host :
       {"localhost", "LocalHost:8080", "127.0.0.1", "127.0.0.1:8080", "127.9.8.7:1", "[::1]", "[::1]:8080"}) {
    EXPECT_TRUE(is_host_allowed(host, {})) << host;
  }
}

TEST(HostName, OtherNamesAreNot) {
  for (const char* host : {"", ":", ":8080", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example:8080",
                           "localhost:80:80", "localhost:x", "127.1", "2130706433", "[::1", "[]", "[::1]x", "[fe80::1]",
                           "::1", "0.0.0.0", "10.0.0.7", "user@localhost", "localhost "}) {
    EXPECT_FALSE(is_host_allowed(host, {})) << host;
  }
}

TEST(HostName, NamesInTheListAreAllowedToo) {
  const auto names = parse_host_names("robot.example, 10.0.0.7,[fe80::1]");
  ASSERT_TRUE(names.ok());
  EXPECT_THAT(*names, ElementsAre("robot.example", "10.0.0.7", "[fe80::1]"));
  for (const char* host : {"robot.example", "ROBOT.example:443", "10.0.0.7:8080", "[fe80::1]:1", "localhost"}) {
    EXPECT_TRUE(is_host_allowed(host, *names)) << host;
  }
  EXPECT_FALSE(is_host_allowed("a.robot.example", *names));
}

TEST(HostName, ListsAreChecked) {
  EXPECT_TRUE(parse_host_names("")->empty());
  for (const char* list : {"http://robot", "robot:80", "a,,b", "a b", "*", "[x]", "[]"}) {
    EXPECT_EQ(parse_host_names(list).status().code(), absl::StatusCode::kInvalidArgument) << list;
  }
}

}  // namespace
}  // namespace segserve::server
