// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/legend.hpp"

#include <gmock/gmock.h>

namespace segserve::picture {
namespace {

TEST(Legend, HasTheLargestFirstAndNoZero) {
  const auto entries = legend_entries(std::vector<std::uint32_t>{0, 0, 0, 0, 5, 2, 2, 2, 5, 9}, SegmentColors());
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].label, 2U);
  EXPECT_EQ(entries[0].points, 3U);
  EXPECT_EQ(entries[0].rgb, segment_color(2));
  EXPECT_EQ(entries[1].label, 5U);
  EXPECT_EQ(entries[2].label, 9U);
}

TEST(Legend, LeavesOutWhatHasNoRoom) {
  EXPECT_EQ(legend_room(3, 1000), 3U);
  EXPECT_EQ(legend_room(100, 480), 19U) << "20 rows below the head, of which the last tells of the others";
  EXPECT_EQ(legend_room(100, 10), 0U);
}

TEST(Legend, ColumnsFitTheNumbers) {
  const std::vector<LegendEntry> small{{1, 0xFF0000, 10}};
  const std::vector<LegendEntry> large{{123456, 0xFF0000, 1'000'000'000}};
  EXPECT_EQ(legend_width(large) - legend_width(small), (5 + 4) * kTextAdvance);
}

TEST(Legend, OfASmallPictureHasRoomForADozenSegments) {
  Raster raster(32, 24);
  std::vector<std::uint32_t> labels(32 * 24);
  for (std::uint32_t i = 0; i < labels.size(); ++i) raster.point[i] = i, labels[i] = 1 + i % 20;
  const Image image = with_legend(blank_image(32, 24, 0x808080), raster, labels, SegmentColors());
  EXPECT_GE(legend_room(20, static_cast<int>(image.height)), 12U);
  const int few = static_cast<int>(
      with_legend(blank_image(32, 24, 0), raster, std::vector<std::uint32_t>(labels.size(), 1), SegmentColors())
          .height);
  EXPECT_LT(few, static_cast<int>(image.height)) << "one segment needs less";
}

TEST(Legend, NumbersStandOnLargeSegmentsOnly) {
  Raster raster(100, 100);
  std::vector<std::uint32_t> labels(100 * 100, 1);
  for (std::uint32_t i = 0; i < labels.size(); ++i) raster.point[i] = i;
  for (std::uint32_t i = 0; i < 40; ++i) labels[i] = 2;
  SegmentColors colors;
  const Image plain = blank_image(100, 100, 0x808080);
  const Image image = with_legend(plain, raster, labels, colors);
  ASSERT_GT(image.width, 200U);
  std::size_t changed = 0;
  for (std::uint32_t y = 0; y < 100; ++y) {
    for (std::uint32_t x = 0; x < 100; ++x) {
      const bool differs = image.rgb[3 * (std::size_t{y} * image.width + x)] != 0x80;
      const bool is_near_middle = x > 30 && x < 70 && y > 30 && y < 70;
      changed += differs ? 1 : 0;
      EXPECT_TRUE(is_near_middle || !differs) << x << " " << y;
    }
  }
  EXPECT_GT(changed, 100U);
}

}  // namespace
}  // namespace segserve::picture
