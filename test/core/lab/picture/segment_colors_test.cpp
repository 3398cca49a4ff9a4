// SPDX-License-Identifier: Apache-2.0
#include "core/lab/picture/segment_colors.hpp"

#include <gmock/gmock.h>

#include <random>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

using testing::ElementsAre;
using testing::Pair;

/// A row of pixels that show these labels; each point is its own pixel.
struct Row {
  explicit Row(std::vector<std::uint32_t> labels)
      : label(std::move(labels)), raster(static_cast<std::uint32_t>(label.size()), 1) {
    for (std::uint32_t i = 0; i < label.size(); ++i) raster.point[i] = i;
  }
  std::vector<std::uint32_t> label;
  Raster raster;
};

TEST(ColorDifference, IsOneFromBlackToWhiteAndSmallForShades) {
  EXPECT_NEAR(color_difference(0x000000, 0xFFFFFF), 1.0, 1e-3);
  EXPECT_EQ(color_difference(0x123456, 0x123456), 0.0);
  EXPECT_LT(color_difference(0x808080, 0x858585), 0.03);
}

TEST(LabelNeighbors, AreAtMostTwoPixelsApart) {
  const Row row({1, 1, 2, 0, 3, 3, 0, 0, 4});
  EXPECT_THAT(label_neighbors(row.raster, row.label), ElementsAre(Pair(1, 2), Pair(2, 3)));
}

TEST(LabelNeighbors, ComeFromTheMostSeenToTheLeast) {
  const Row row({7, 3, 3, 3, 0, 0, 0, 0, 5, 5});
  EXPECT_THAT(labels_by_size(row.raster, row.label), ElementsAre(3, 5, 7));
}

TEST(SegmentColors, AreTheUsualOnesWithoutConflict) {
  SegmentColors colors;
  colors.update(std::vector<std::uint32_t>{1, 2, 3}, {});
  EXPECT_EQ(colors(2), segment_color(2));
  EXPECT_EQ(colors(99), segment_color(99));
}

TEST(SegmentColors, OfNeighborsNeverLookAlike) {
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    std::vector<std::uint32_t> labels;
    std::vector<SegmentColors::LabelPair> neighbors;
    for (std::uint32_t label = 1; label <= 300; ++label) {
      labels.push_back(label);
      for (int i = 0; i < 4 && label > 1; ++i) neighbors.emplace_back(1 + random() % (label - 1), label);
    }
    SegmentColors colors;
    colors.update(labels, neighbors);
    std::size_t usual = 0;
    for (const auto& [a, b] : neighbors) EXPECT_GE(color_difference(colors(a), colors(b)), kLeastColorDifference);
    for (const std::uint32_t label : labels) usual += colors(label) == segment_color(label) ? 1 : 0;
    EXPECT_GT(usual, 150U) << "most segments keep their usual color";
  }
}

TEST(SegmentColors, StayFromPictureToPicture) {
  // Two labels whose usual colors look alike.
  std::uint32_t like_one = 2;
  while (color_difference(segment_color(1), segment_color(like_one)) >= kLeastColorDifference) ++like_one;
  const std::vector<SegmentColors::LabelPair> touch{{1, like_one}};
  SegmentColors colors;
  colors.update(std::vector<std::uint32_t>{1, like_one}, touch);
  const std::uint32_t first = colors(like_one);
  EXPECT_NE(first, segment_color(like_one));
  EXPECT_EQ(colors(1), segment_color(1));
  // They do not touch any more, and a larger segment has come.
  colors.update(std::vector<std::uint32_t>{like_one + 1, like_one, 1}, {});
  EXPECT_EQ(colors(like_one), first);
  colors.update(std::vector<std::uint32_t>{5}, {});
  EXPECT_EQ(colors(like_one), first) << "also when it was out of sight";
}

TEST(SegmentColors, OfAPictureAreThoseThatRenderPaints) {
  Cloud cloud;
  cloud.resize(6, true);
  cloud.rgb.assign(6, 0x404040);
  cloud.width = 3;
  cloud.height = 2;
  for (std::size_t i = 0; i < 6; ++i) cloud.z[i] = 1;
  const std::vector<std::uint32_t> labels{1, 2, 2, 1, 2, 2};
  const SegmentColors colors = colors_in_picture(cloud, labels);
  const Image image = render(cloud, labels, {.blend = 1.0F, .borders = false});
  const double ratio = static_cast<double>(image.rgb[1]) / image.rgb[2];
  EXPECT_NEAR(ratio, static_cast<double>(green(colors(1))) / blue(colors(1)), 0.02);
  EXPECT_NE(colors(1), colors(2));
}

}  // namespace
}  // namespace segserve::picture
