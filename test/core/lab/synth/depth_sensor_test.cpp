// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/depth_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace segserve::synth {
namespace {

DepthImage wall(std::uint32_t width, std::uint32_t height, double depth) {
  const std::size_t pixels = std::size_t{width} * height;
  return {width, height, std::vector<double>(pixels, depth), std::vector<float>(pixels, 1.0F),
          std::vector<std::uint32_t>(pixels, 1)};
}

// A board in front of a wall, columns `left` to `right` - 1.
DepthImage board_and_wall(std::uint32_t left, std::uint32_t right, double front, double back) {
  DepthImage image = wall(640, 40, back);
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = left; u < right; ++u) {
      image.depth[std::size_t{v} * 640 + u] = front;
      image.label[std::size_t{v} * 640 + u] = 20;
    }
  }
  return image;
}

TEST(DepthSensorTest, NoNoiseAndNoHolesChangeNothing) {
  DepthImage image = board_and_wall(200, 300, 0.8, 1.2);
  const DepthImage before = image;
  Random random(1);
  DepthSensor{.noise = 0, .holes = false}.measure(image, random);
  EXPECT_EQ(image.depth, before.depth);
  EXPECT_EQ(image.label, before.label);
}

class NoiseTest : public testing::TestWithParam<double> {};

TEST_P(NoiseTest, HasTheDeviationOfTheKinectAndNoBias) {
  const double depth = GetParam();
  DepthImage image = wall(640, 480, depth);
  Random random(2);
  DepthSensor{.holes = false}.measure(image, random);
  double sum = 0, squares = 0;
  for (const double z : image.depth) {
    sum += z - depth;
    squares += (z - depth) * (z - depth);
  }
  const double pixels = static_cast<double>(image.depth.size());
  const double step = depth * depth / (8 * 525 * 0.075);
  const double expected = std::sqrt(0.8725 * axial_noise(depth) * axial_noise(depth) + step * step / 12);
  EXPECT_NEAR(std::sqrt(squares / pixels), expected, 0.05 * expected);
  EXPECT_NEAR(sum / pixels, 0, 0.1 * expected);
}
INSTANTIATE_TEST_SUITE_P(Depths, NoiseTest, testing::Values(0.7, 1.0, 1.5, 2.5));

TEST(DepthSensorTest, DepthsAreStepsOfAnEighthOfAPixelOfDisparity) {
  DepthImage image = wall(64, 48, 1.1);
  Random random(3);
  DepthSensor{.holes = false}.measure(image, random);
  for (const double z : image.depth) {
    const double steps = 8 * 525 * 0.075 / z;
    ASSERT_NEAR(steps, std::round(steps), 1e-9);
  }
}

TEST(DepthSensorTest, TheProjectorsShadowIsLeftOfTheBoardAndAsWideAsTheParallax) {
  DepthImage image = board_and_wall(300, 400, 0.8, 1.2);
  Random random(4);
  DepthSensor{.noise = 0}.measure(image, random);
  int missing_left = 0, missing_right = 0, missing_on_board = 0;
  for (std::uint32_t u = 0; u < 640; ++u) {
    const bool missing = image.depth[20 * 640 + u] == 0;
    missing_left += missing && u >= 200 && u < 300 ? 1 : 0;
    missing_on_board += missing && u >= 300 && u < 400 ? 1 : 0;
    missing_right += missing && u >= 400 && u < 500 ? 1 : 0;
  }
  const double parallax = 525 * 0.075 * (1 / 0.8 - 1 / 1.2);
  EXPECT_NEAR(missing_left, parallax, 2);
  EXPECT_LE(missing_right, 8);  // a spot at most
  EXPECT_LE(missing_on_board, 8);
}

TEST(DepthSensorTest, GrazingSurfacesAreLost) {
  DepthImage image = wall(64, 64, 1.0);
  for (float& c : image.incidence) c = 0.01F;
  Random random(5);
  DepthSensor{}.measure(image, random);
  for (const double z : image.depth) ASSERT_EQ(z, 0);
}

TEST(DepthSensorTest, BordersFrayAndTakeTheirLabelsAlong) {
  DepthImage image = board_and_wall(300, 400, 0.8, 1.2);
  Random random(6);
  DepthSensor{.holes = false}.measure(image, random);
  int moved = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < 640; ++u) {
      const std::size_t i = std::size_t{v} * 640 + u;
      ASSERT_EQ(image.label[i], image.depth[i] < 1 ? 20U : 1U);
      const bool was_board = u >= 300 && u < 400;
      if (was_board != (image.label[i] == 20)) {
        ++moved;
        EXPECT_LE(std::min(std::abs(static_cast<int>(u) - 300), std::abs(static_cast<int>(u) - 400)), 2);
      }
    }
  }
  EXPECT_GT(moved, 5);
}

}  // namespace
}  // namespace segserve::synth
