// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

TEST(Shrink, TakesMeansOfSquares) {
  // 4 x 2 pixels whose red is 0 to 7; green is 10 everywhere, blue 255 on the right half.
  Image image{4, 2, {}};
  for (std::uint8_t i = 0; i < 8; ++i) {
    for (const int channel : {static_cast<int>(i), 10, i % 4 < 2 ? 0 : 255}) {
      image.rgb.push_back(static_cast<std::uint8_t>(channel));
    }
  }
  const Image small = shrink(image, 2);
  EXPECT_EQ(small.width, 2U);
  EXPECT_EQ(small.height, 1U);
  EXPECT_THAT(small.rgb, testing::ElementsAre(3, 10, 0, 5, 10, 255));  // 2.5 and 4.5 are rounded up
}

TEST(Shrink, UsesTheSmallestSquaresThatFit) {
  const Image image{641, 480, std::vector<std::uint8_t>(std::size_t{3} * 641 * 480, 7)};
  EXPECT_EQ(shrink(image, 641).width, 641U);
  EXPECT_EQ(shrink(image, 640).width, 320U);
  EXPECT_EQ(shrink(image, 640).height, 240U);
  EXPECT_EQ(shrink(image, 320).width, 213U);
  EXPECT_EQ(shrink(image, 0).width, 1U);
  EXPECT_THAT(shrink(image, 320).rgb, testing::Each(7));
}

TEST(Shrink, KeepsARowOfAnImageLowerThanASquare) {
  const Image small = shrink({9, 1, std::vector<std::uint8_t>(27, 9)}, 3);
  EXPECT_EQ(small.width, 3U);
  EXPECT_EQ(small.height, 1U);
  EXPECT_THAT(small.rgb, testing::Each(9));
}

}  // namespace
}  // namespace segserve::picture
