// SPDX-License-Identifier: Apache-2.0
// A cloud that is written to a PCD file and read again is the same, bit for bit.

#include "segserve/codec/pcd.hpp"
#include "test/core/codec/support/sample_cloud.hpp"

namespace segserve::codec {
namespace {

struct Shape {
  std::uint32_t width, height;
  bool color, label;
};

class PcdRoundTrip : public testing::TestWithParam<std::tuple<PcdEncoding, Shape>> {};

TEST_P(PcdRoundTrip, KeepsEverything) {
  const auto& [encoding, shape] = GetParam();
  Sample sample = make_sample(shape.width, shape.width, shape.height, shape.color, shape.label);
  sample.cloud.view = shape.height > 1 ? View::camera() : View::world(0.1F, -2.5F, 3e-7F);
  const std::string file = encode_pcd(sample.cloud, sample.label, encoding);
  const auto read = decode_pcd(bytes_of(file), DecodeLimits{});
  ASSERT_TRUE(read.ok()) << read.status();
  expect_same_points(read->cloud, sample.cloud);
  EXPECT_EQ(read->label, sample.label);
  EXPECT_EQ(read->cloud.width, shape.width);
  EXPECT_EQ(read->cloud.height, shape.height);
  EXPECT_EQ(read->cloud.view, sample.cloud.view);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, PcdRoundTrip,
    testing::Combine(testing::Values(PcdEncoding::kAscii, PcdEncoding::kBinary, PcdEncoding::kBinaryCompressed),
                     testing::Values(Shape{1, 1, false, false}, Shape{1, 1, true, true}, Shape{3, 1, true, false},
                                     Shape{0, 1, true, false}, Shape{17, 5, false, true}, Shape{33, 7, true, true},
                                     Shape{641, 1, true, true}, Shape{127, 129, true, true})));

TEST(PcdEncode, AllColorsOfTheGrayAxisAndTheCornersSurviveInText) {
  std::vector<std::uint32_t> colors;
  for (std::uint32_t v = 0; v < 256; ++v) {
    for (const std::uint32_t rgb : {v * 0x010101U, v << 16U, v << 8U, v, 0xFFFF00U | v, 0xFF0000U | v << 8U}) {
      colors.push_back(rgb);
    }
  }
  Sample sample = make_sample(1, static_cast<std::uint32_t>(colors.size()), 1, true, false);
  sample.cloud.rgb = colors;
  const std::string file = encode_pcd(sample.cloud, {}, PcdEncoding::kAscii);
  const auto read = decode_pcd(bytes_of(file), DecodeLimits{});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->cloud.rgb, colors);
}

TEST(PcdEncode, TheUnusedTopByteOfAColorIsDropped) {
  Cloud cloud{{1}, {2}, {3}, {0xFF123456U}, 1, 1, View::world()};
  for (const PcdEncoding encoding : {PcdEncoding::kAscii, PcdEncoding::kBinary, PcdEncoding::kBinaryCompressed}) {
    const std::string file = encode_pcd(cloud, {}, encoding);
    const auto read = decode_pcd(bytes_of(file), DecodeLimits{});
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_THAT(read->cloud.rgb, testing::ElementsAre(0x123456U));
  }
}

TEST(PcdEncode, CompressedIsSmallerThanBinaryOnAScene) {
  Sample sample = make_sample(1, 320, 240, true, false);
  for (std::size_t i = 0; i < sample.cloud.size(); ++i) sample.cloud.x[i] = sample.cloud.y[i] = sample.cloud.z[i] = 1;
  const auto size = [&](PcdEncoding encoding) { return encode_pcd(sample.cloud, {}, encoding).size(); };
  EXPECT_LT(size(PcdEncoding::kBinaryCompressed), size(PcdEncoding::kBinary) / 2);
}

}  // namespace
}  // namespace segserve::codec
