// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/packed_integers.hpp"

#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

TEST(Integers, TheSmallestWidthThatHoldsTheLargestIsChosen) {
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> widths{{0, 1},     {255, 1},   {256, 2},
                                                                    {65535, 2}, {65536, 4}, {0xFFFFFFFFU, 4}};
  for (const auto& [largest, width] : widths) {
    const std::vector<std::uint32_t> values{0, largest, 1};
    const EncodedIntegers encoded = encode_integers(values);
    EXPECT_EQ(encoded.bytes_per_value, width) << largest;
    EXPECT_EQ(encoded.bytes.size(), 3 * width);
    const auto decoded = decode_integers(encoded.bytes, width);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, values);
  }
}

TEST(Integers, AreLittleEndian) {
  const std::vector<std::uint32_t> values{0x0102, 3};
  EXPECT_EQ(encode_integers(values).bytes, std::string("\x02\x01\x03\x00", 4));
}

TEST(Integers, NoValuesAreNoBytes) {
  EXPECT_EQ(encode_integers({}).bytes, "");
  EXPECT_EQ(decode_integers("", 1)->size(), 0U);
}

TEST(Integers, WrongWidthsAndLengthsAreNamed) {
  for (const std::uint32_t width : {0U, 3U, 8U})
    expect_fault(decode_integers("123456", width).status(), "bytes per value");
  expect_fault(decode_integers("123456", 4).status(), "6 bytes are not a whole number of values of 4 bytes");
  expect_fault(decode_integers("1", 2).status(), "1 bytes are not a whole number of values of 2 bytes");
}

}  // namespace
}  // namespace segserve::codec
