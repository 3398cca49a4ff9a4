// SPDX-License-Identifier: Apache-2.0
#include "server/options/listen_address.hpp"

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

TEST(ListenAddress, ReadsHostAndPort) {
  const auto v4 = parse_listen_address("127.0.0.1:50051");
  ASSERT_TRUE(v4.ok());
  EXPECT_EQ(v4->host, "127.0.0.1");
  EXPECT_EQ(v4->port, "50051");
  EXPECT_EQ(with_port(*v4, 7), "127.0.0.1:7");

  const auto v6 = parse_listen_address("[::1]:0");
  ASSERT_TRUE(v6.ok());
  EXPECT_EQ(v6->host, "::1");
  EXPECT_EQ(with_port(*v6, 7), "[::1]:7");

  const auto path = parse_listen_address("unix:/run/a.sock");
  ASSERT_TRUE(path.ok());
  EXPECT_EQ(with_port(*path, 0), "unix:/run/a.sock");
}

TEST(ListenAddress, RefusesEverythingElse) {
  for (const char* text : {"", "localhost", ":50051", "1.2.3.4:", "1.2.3.4:x", "1.2.3.4:65536", "1.2.3.4:-1", "::1:80",
                           "unix:", "[]:80"}) {
    const auto address = parse_listen_address(text);
    EXPECT_EQ(address.status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(ListenAddress, BoundsThePathOfAUnixSocket) {
  EXPECT_TRUE(parse_listen_address("unix:/" + std::string(106, 'x')).ok());
  const absl::Status refused = parse_listen_address("unix:/" + std::string(107, 'x')).status();
  EXPECT_NE(refused.message().find("at most 107 bytes"), std::string::npos) << refused;
}

TEST(ListenAddress, KnowsWhoCanReachIt) {
  for (const char* text : {"localhost:1", "127.0.0.1:1", "127.9.9.9:1", "[::1]:1", "unix:/a"}) {
    EXPECT_TRUE(parse_listen_address(text)->is_loopback()) << text;
  }
  for (const char* text : {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "example.com:1", "localhost.example.com:1",
                           "128.0.0.1:1", "[::ffff:10.0.0.1]:1"}) {
    EXPECT_FALSE(parse_listen_address(text)->is_loopback()) << text;
  }
}

}  // namespace
}  // namespace segserve::server
