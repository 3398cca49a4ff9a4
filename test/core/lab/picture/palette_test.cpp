// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

double distance(std::uint32_t a, std::uint32_t b) {
  return std::hypot(red(a) - red(b), green(a) - green(b), blue(a) - blue(b));
}

/// The nearest two colors of a run of labels.
double closest(std::uint32_t first, std::uint32_t count, std::uint32_t step) {
  double least = 1e9;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t k = 0; k < i; ++k) {
      least = std::min(least, distance(segment_color(first + i * step), segment_color(first + k * step)));
    }
  }
  return least;
}

TEST(Palette, NoPointIsDarkGray) {
  const std::uint32_t color = segment_color(0);
  EXPECT_LT(std::max({red(color), green(color), blue(color)}), 64);
  EXPECT_LT(std::abs(red(color) - green(color)) + std::abs(green(color) - blue(color)), 10);
}

TEST(Palette, IsStable) {
  // Pictures of the same labels look the same tomorrow.
  EXPECT_EQ(segment_color(1), 0x01A9F8U);
  EXPECT_EQ(segment_color(20), segment_color(20));
  EXPECT_NE(segment_color(1), segment_color(2));
}

TEST(Palette, ColorsOfASceneAreFarApart) {
  EXPECT_GT(closest(1, 16, 1), 30.0);
  EXPECT_GT(closest(10, 12, 10), 30.0);  // ground truth counts objects in tens
  EXPECT_GT(closest(1000, 16, 1), 30.0);
}

TEST(Palette, NeighboringLabelsAreVeryDifferentAndNoneIsDark) {
  for (std::uint32_t label = 1; label < 3000; ++label) {
    const std::uint32_t color = segment_color(label);
    EXPECT_GT(distance(color, segment_color(label + 1)), 90.0) << label;
    EXPECT_GT(std::max({red(color), green(color), blue(color)}), 110) << label;
  }
}

TEST(Palette, HardlyRepeats) {
  std::set<std::uint32_t> colors;
  for (std::uint32_t label = 1; label <= 300; ++label) colors.insert(segment_color(label));
  EXPECT_GT(colors.size(), 295U);
}

}  // namespace
}  // namespace segserve::picture
