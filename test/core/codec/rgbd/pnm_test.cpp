// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/codec/rgbd/pnm_image.hpp"
#include "test/core/codec/support/image_files.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

using std::string_literals::operator""s;

absl::StatusOr<GrayImage> pgm_of(const std::string& bytes, const DecodeLimits& limits = {}) {
  GoOn go_on;
  return decode_pgm_depth(bytes, limits, go_on.check);
}
absl::StatusOr<FloatImage> pfm_of(const std::string& bytes, const DecodeLimits& limits = {}) {
  GoOn go_on;
  return decode_pfm(bytes, limits, go_on.check);
}
absl::StatusOr<ColorImage> colors_in(const std::string& bytes, const DecodeLimits& limits = {}) {
  GoOn go_on;
  return decode_pnm_color(bytes, limits, go_on.check);
}

using Depths = std::vector<std::uint16_t>;

TEST(Pnm, DepthIsReadFromBytesAndText) {
  const std::string pixels("\x03\xe8\x00\x00\xff\xff\x0a\x0d\x00\x01\x12\x34", 12);
  const Depths expected{1000, 0, 65535, 0x0a0d, 1, 0x1234};
  for (const std::string& header :
       {"P5\n3 2\n65535\n"s, "P5 3 2 65535 "s, "P5\r\n3 2\r\n65535\r\n"s, "P5\n# by a camera\n3 # wide\n2\n65535\n"s}) {
    const auto image = pgm_of(header + pixels);
    ASSERT_TRUE(image.ok()) << header << image.status();
    EXPECT_EQ(image->size, (ImageSize{3, 2}));
    EXPECT_EQ(image->pixels, expected);
  }
  const auto text = pgm_of("P2\n3 2\n65535\n1000 0 65535 # first row\n# second row\n2573\t1\r\n4660");
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(text->pixels, expected);
  // The header's largest value is often that of the image.
  EXPECT_EQ(pgm_of("P2 2 1 1200 1200 7").value().pixels, (Depths{1200, 7}));
}

TEST(Pnm, PicturesOfDepthAreRefused) {
  expect_fault(pgm_of("P5 2 1 255 ab").status(), "PGM: its largest value is 255, but depth needs 16 bits");
  expect_fault(pgm_of("P6 1 1 65535 abcdef").status(), "PPM: it is a color image, but depth must be gray");
}

TEST(Pnm, FloatsStandFromTheBottomInEitherByteOrder) {
  const std::vector<float> rows{3, 4, std::numeric_limits<float>::quiet_NaN(), 2};
  std::string bytes(16, '\0');
  std::memcpy(bytes.data(), rows.data(), 16);
  const auto little = pfm_of("Pf\n2 2\n-1.0\n" + bytes);
  ASSERT_TRUE(little.ok()) << little.status();
  EXPECT_TRUE(std::isnan(little->pixels[0]));
  EXPECT_EQ(little->pixels[1], 2);
  EXPECT_EQ(little->pixels[2], 3);
  EXPECT_EQ(little->pixels[3], 4);
  for (std::size_t i = 0; i < 16; i += 4) std::reverse(bytes.begin() + i, bytes.begin() + i + 4);
  const auto big = pfm_of("Pf\n2 2\n1\n" + bytes);
  ASSERT_TRUE(big.ok()) << big.status();
  EXPECT_EQ(big->pixels[3], 4);
  expect_fault(pfm_of("Pf 2 2 0 " + bytes).status(), "'0' is not the scale of a PFM");
  expect_fault(pfm_of("PF 2 2 -1 " + bytes).status(), "'PF' is not P2, P3, P5, P6 or Pf");
  expect_fault(pfm_of("Pf 2 2 -1 " + bytes.substr(1)).status(), "PFM: the bytes end too early");
}

TEST(Pnm, ColorsAreScaledTo8Bits) {
  using Colors = std::vector<std::uint8_t>;
  EXPECT_EQ(colors_in("P6 2 1 255 abcdef").value().rgb, (Colors{'a', 'b', 'c', 'd', 'e', 'f'}));
  EXPECT_EQ(colors_in("P3 1 1 15  0 7 15").value().rgb, (Colors{0, 119, 255}));
  EXPECT_EQ(colors_in("P6 1 1 65535 \xff\xff\x80\x80\x00\x00"s).value().rgb, (Colors{255, 128, 0}));
  EXPECT_EQ(colors_in("P5 2 1 255 ab").value().rgb, (Colors{'a', 'a', 'a', 'b', 'b', 'b'}));
  expect_fault(colors_in("Pf 1 1 -1 abcd").status(), "PFM: it holds floats, but colors must be integers");
}

TEST(Pnm, DamageIsNamed) {
  expect_fault(pgm_of("P5 3 2 65535 abcdefghijk").status(), "PGM: the bytes end too early: 3 x 2 pixels need 6");
  expect_fault(pgm_of("P2 3 2 65535 1 2 3 4 5").status(), "PGM: the bytes end too early");
  expect_fault(pgm_of("P2 2 1 1000 1 1001").status(), "PGM: number 2 of 2 is missing, or is no integer from 0 to 1000");
  expect_fault(pgm_of("P2 2 1 1000 1 -2 3").status(), "number 2 of 2");
  expect_fault(pgm_of("P5 1 1 1000 \xff\xff").status(), "PGM: a number is above 1000");
  expect_fault(pgm_of("P5 0 1 1000 aa").status(), "'0' is not the width or height");
  expect_fault(pgm_of("P5 1 1 65536 aa").status(), "'65536' is not a largest value from 1 to 65535");
  expect_fault(pgm_of("P5 3 2").status(), "'' is not the width or height");
  expect_fault(pgm_of("P5 #" + std::string(100'000, 'x')).status(), "is not the width or height");
  expect_fault(colors_in("P6 1 1 255 ab").status(), "PPM: the bytes end too early");
}

TEST(Pnm, ClaimsAreComparedWithLimitsAndBytesBeforeAllocation) {
  expect_over_limit(pgm_of("P5 100000 100000 65535 ab").status(), "max_points", "100000 x 100000 pixels");
  expect_over_limit(pfm_of("Pf 2 2 -1 ab", {.max_bytes = 15}).status(), "max_bytes", "2 x 2 pixels of 4 bytes");
  expect_over_limit(colors_in("P3 2 2 255 ab", {.max_points = 3}).status(), "max_points", "2 x 2 pixels");
  expect_fault(pgm_of("P2 8000 8000 65535 1 2").status(), "the bytes end too early");
}

TEST(Pnm, ItIsStopped) {
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled, std::nullopt);
  StopCheck check(stop);
  EXPECT_TRUE(absl::IsCancelled(decode_pgm_depth("P5 1 1 65535 ab", {}, check).status()));
  EXPECT_TRUE(absl::IsCancelled(decode_pgm_depth("P2 1 1 65535 1", {}, check).status()));
  EXPECT_TRUE(absl::IsCancelled(decode_pfm("Pf 1 1 -1 abcd", {}, check).status()));
  EXPECT_TRUE(absl::IsCancelled(decode_pnm_color("P6 1 1 255 abc", {}, check).status()));
}

}  // namespace
}  // namespace segserve::codec
