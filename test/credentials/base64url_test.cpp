// SPDX-License-Identifier: Apache-2.0
#include "credentials/base64url.hpp"

#include <string>

#include "gtest/gtest.h"

namespace segserve::credentials {
namespace {

TEST(Base64url, IsThatOfJsonWebTokens) {
  EXPECT_EQ(to_base64url(std::string("\x14\xfb\x9c\x03\xd9\x7e", 6)), "FPucA9l-");
  EXPECT_EQ(to_base64url("\xff\xff\xff\xff"), "_____w");
  EXPECT_EQ(from_base64url("_____w"), "\xff\xff\xff\xff");
  EXPECT_EQ(from_base64url(""), "");
}

TEST(Base64url, HasOneSpellingOfEachText) {
  for (const char* other : {"_____w==", "_____w=", "_____x", "_____w ", "\n_____w", "/////w", "_____", "A", "AB.C"}) {
    EXPECT_EQ(from_base64url(other), std::nullopt) << other;
  }
}

}  // namespace
}  // namespace segserve::credentials
