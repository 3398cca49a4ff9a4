#include "segserve/codec/labels.hpp"

#include "test/core/codec/sample.hpp"

namespace segserve::codec {
namespace {

TEST(Labels, TheSmallestWidthThatHoldsTheLargestIsChosen) {
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> widths{{0, 1},     {255, 1},   {256, 2},
                                                                    {65535, 2}, {65536, 4}, {0xFFFFFFFFU, 4}};
  for (const auto& [largest, width] : widths) {
    const std::vector<std::uint32_t> labels{0, largest, 1};
    const EncodedLabels encoded = encode_labels(labels);
    EXPECT_EQ(encoded.bytes_per_label, width) << largest;
    EXPECT_EQ(encoded.bytes.size(), 3 * width);
    const auto decoded = decode_labels(encoded.bytes, width);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, labels);
  }
}

TEST(Labels, AreLittleEndian) {
  const std::vector<std::uint32_t> labels{0x0102, 3};
  EXPECT_EQ(encode_labels(labels).bytes, std::string("\x02\x01\x03\x00", 4));
}

TEST(Labels, OfNoPointsAreNoBytes) {
  EXPECT_EQ(encode_labels({}).bytes, "");
  EXPECT_EQ(decode_labels("", 1)->size(), 0U);
}

TEST(Labels, WrongWidthsAndLengthsAreNamed) {
  for (const std::uint32_t width : {0U, 3U, 8U})
    expect_fault(decode_labels("123456", width).status(), "bytes per label");
  expect_fault(decode_labels("123456", 4).status(), "6 bytes are no whole number of labels of 4 bytes");
  expect_fault(decode_labels("1", 2).status(), "1 bytes are no whole number of labels of 2 bytes");
}

}  // namespace
}  // namespace segserve::codec
