// SPDX-License-Identifier: Apache-2.0
#include "server/stream/credit.hpp"

#include "gtest/gtest.h"

namespace segserve::server {
namespace {

TEST(CreditLimits, GrantWhatIsWantedWithinTheLimitsOfAStream) {
  constexpr CreditLimits kLimits{.most_per_stream = {.frames = 4, .bytes = 1000}, .default_bytes_per_stream = 300};
  EXPECT_EQ(kLimits.grant({}), (Credit{.frames = 4, .bytes = 300}));
  EXPECT_EQ(kLimits.grant({.frames = 2, .bytes = 50}), (Credit{.frames = 2, .bytes = 50}));
  EXPECT_EQ(kLimits.grant({.frames = 9, .bytes = 5000}), (Credit{.frames = 4, .bytes = 1000}));
}

TEST(CreditLimits, TheDefaultIsWithinTheLimitsToo) {
  constexpr CreditLimits kLimits{.most_per_stream = {.frames = 4, .bytes = 100}, .default_bytes_per_stream = 300};
  EXPECT_EQ(kLimits.grant({}).bytes, 100U);
}

}  // namespace
}  // namespace segserve::server
