// SPDX-License-Identifier: Apache-2.0
#include "client/fleet/retry.hpp"

#include "gtest/gtest.h"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;

TEST(Backoff, DoublesUpToALimitWithJitterAndObeysTheServer) {
  const RetryOptions retry{.first_backoff = milliseconds(100), .max_backoff = milliseconds(1000)};
  std::minstd_rand random(3);
  for (int i = 0; i < 100; ++i) {
    EXPECT_GE(backoff(retry, 1, {}, random), milliseconds(50));
    EXPECT_LE(backoff(retry, 1, {}, random), milliseconds(100));
    EXPECT_GE(backoff(retry, 3, {}, random), milliseconds(200));
    EXPECT_LE(backoff(retry, 3, {}, random), milliseconds(400));
    EXPECT_LE(backoff(retry, 1000, {}, random), milliseconds(1000));
    EXPECT_EQ(backoff(retry, 1, milliseconds(5000), random), milliseconds(5000));
  }
}

}  // namespace
}  // namespace segserve::client
