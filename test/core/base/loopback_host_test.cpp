// SPDX-License-Identifier: Apache-2.0
#include "core/base/loopback_host.hpp"

#include "gtest/gtest.h"

namespace segserve {
namespace {

TEST(LoopbackHost, IsThisMachineAndNothingElse) {
  for (const char* host : {"localhost", "LocalHost", "127.0.0.1", "127.255.0.3", "::1", "0:0:0:0:0:0:0:1"}) {
    EXPECT_TRUE(is_loopback_host(host)) << host;
  }
  for (const char* host : {"", "localhost.example", "127.example", "127.0.0.1.example", "127.1", "128.0.0.1", "0.0.0.0",
                           "::", "[::1]", "robot", " localhost"}) {
    EXPECT_FALSE(is_loopback_host(host)) << host;
  }
}

}  // namespace
}  // namespace segserve
