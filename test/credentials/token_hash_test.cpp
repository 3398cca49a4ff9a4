// SPDX-License-Identifier: Apache-2.0
#include "credentials/token_hash.hpp"

#include <set>
#include <string>

#include "credentials/new_token.hpp"
#include "gtest/gtest.h"

namespace segserve::credentials {
namespace {

TEST(TokenHash, IsSha256) {
  constexpr const char* kOfAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";  // FIPS 180-2
  EXPECT_EQ(to_hex(hash_of("abc")), kOfAbc);
  EXPECT_EQ(hash_from_hex(kOfAbc), hash_of("abc"));
  EXPECT_EQ(hash_from_hex("BA7816BF8F01CFEA414140DE5DAE2223B00361A396177A9CB410FF61F20015AD"), hash_of("abc"));
}

TEST(TokenHash, HasSixtyFourDigits) {
  const std::string hex = to_hex(hash_of("abc"));
  for (const std::string& wrong : {hex.substr(1), hex + "0", hex.substr(1) + "g", std::string()}) {
    EXPECT_EQ(hash_from_hex(wrong), std::nullopt) << wrong;
  }
}

TEST(TokenHash, EveryByteIsCompared) {
  const TokenHash hash = hash_of("abc");
  EXPECT_TRUE(equal_in_constant_time(hash, hash_of("abc")));
  for (std::size_t i = 0; i < hash.size(); ++i) {
    TokenHash other = hash;
    other[i] ^= 1;
    EXPECT_FALSE(equal_in_constant_time(hash, other)) << i;
  }
}

TEST(NewToken, CannotBeGuessed) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const auto token = new_token();
    ASSERT_TRUE(token.ok());
    EXPECT_TRUE(token->starts_with("segserve_"));
    EXPECT_EQ(token->size(), 9U + 43U) << "256 bits in base64url";
    tokens.insert(*token);
  }
  EXPECT_EQ(tokens.size(), 100U);
}

}  // namespace
}  // namespace segserve::credentials
