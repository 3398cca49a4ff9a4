// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/hdr_encoding.hpp"

#include <cstdint>
#include <random>

#include "absl/strings/escaping.h"
#include "gmock/gmock.h"

namespace segserve::bench {
namespace {

TEST(HdrEncoding, ComesBackAsItWas) {
  std::mt19937_64 random(1);
  std::lognormal_distribution<double> distribution(9, 3);
  HdrHistogram histogram;
  for (int i = 0; i < 10'000; ++i) histogram.record(static_cast<std::uint64_t>(distribution(random)));
  histogram.record(0, 1);
  histogram.record(3, std::uint64_t{1} << 40U);
  const auto back = from_hdr_base64(to_hdr_base64(histogram));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->counts(), histogram.counts());
  EXPECT_EQ(back->count(), histogram.count());
  EXPECT_TRUE(from_hdr_base64(to_hdr_base64({}))->counts().empty());
}

TEST(HdrEncoding, TextsOfOthersAreReadAndBrokenOnesRefused) {
  HdrHistogram histogram;
  for (std::uint64_t i = 1; i < 5000; ++i) histogram.record(i);
  const std::string text = to_hdr_base64(histogram);
  EXPECT_TRUE(text.starts_with("HISTFAAA")) << "as with all implementations";
  std::string bytes;
  ASSERT_TRUE(absl::Base64Unescape(text, &bytes));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(from_hdr_base64(absl::Base64Escape(bytes.substr(0, length))).ok());
  }
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ 0x55);
    EXPECT_FALSE(from_hdr_base64(absl::Base64Escape(changed)).ok()) << "byte " << i;  // zlib has a checksum
  }
  EXPECT_FALSE(from_hdr_base64("no base64!").ok());
}

}  // namespace
}  // namespace segserve::bench
