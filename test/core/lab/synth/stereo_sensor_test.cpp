// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/stereo_sensor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace segserve::synth {
namespace {

constexpr std::uint32_t kWidth = 640, kHeight = 60;

DepthImage wall(double depth) {
  const std::size_t pixels = std::size_t{kWidth} * kHeight;
  return {kWidth, kHeight, std::vector<double>(pixels, depth), std::vector<float>(pixels, 1.0F),
          std::vector<std::uint32_t>(pixels, 1)};
}

/// Gray, or with a checkerboard of pixels.
std::vector<Vec3> colors(bool textured) {
  std::vector<Vec3> color(std::size_t{kWidth} * kHeight, {0.5, 0.5, 0.5});
  for (std::size_t i = 0; textured && i < color.size(); ++i) {
    const double light = (i + i / kWidth) % 2 == 0 ? 0.4 : 0.6;
    color[i] = {light, light, light};
  }
  return color;
}

double deviation(const StereoSensor& sensor, double depth, bool textured) {
  DepthImage image = wall(depth);
  Random random(1);
  sensor.measure(colors(textured), image, random);
  double squares = 0;
  for (const double z : image.depth) squares += (z - depth) * (z - depth);
  return std::sqrt(squares / static_cast<double>(image.depth.size()));
}

TEST(StereoSensorTest, NoNoiseAndNoHolesChangeNothing) {
  DepthImage image = wall(2);
  Random random(1);
  StereoSensor{.noise = 0, .holes = false}.measure(colors(false), image, random);
  EXPECT_EQ(image.depth, wall(2).depth);
  EXPECT_EQ(image.label, wall(2).label);
}

TEST(StereoSensorTest, NoiseGrowsWithTheSquareOfTheDepth) {
  const StereoSensor sensor{.holes = false};
  const double near = deviation(sensor, 1, true);
  EXPECT_NEAR(near, 0.06 / (525 * 0.055), 0.0006);
  EXPECT_NEAR(deviation(sensor, 3, true) / near, 9, 0.9);
}

TEST(StereoSensorTest, NoiseIsLargerWithoutTextureUnlessAProjectorIsNear) {
  const StereoSensor passive{.holes = false, .projector = false};
  EXPECT_GT(deviation(passive, 1.5, false), 2.5 * deviation(passive, 1.5, true));
  const StereoSensor active{.holes = false};
  EXPECT_NEAR(deviation(active, 1.5, false), deviation(active, 1.5, true), 1e-12);
  EXPECT_NEAR(deviation(active, 5, false), 2 * deviation(active, 5, true), 0.4 * deviation(active, 5, true));
}

TEST(StereoSensorTest, NoiseComesInWavesOfSeveralPixels) {
  DepthImage image = wall(3);
  Random random(3);
  StereoSensor{.holes = false}.measure(colors(true), image, random);
  double variance = 0, next = 0, far = 0;
  const std::size_t last = image.depth.size() - 60;
  for (std::size_t i = 0; i < last; ++i) {
    const double error = image.depth[i] - 3;
    variance += error * error;
    next += error * (image.depth[i + 1] - 3);
    far += error * (image.depth[i + 60] - 3);
  }
  EXPECT_GT(next / variance, 0.9);
  EXPECT_LT(far / variance, 0.2);
}

TEST(StereoSensorTest, SurfacesWithoutTextureHaveHolesIfThereIsNoProjector) {
  const auto missing = [](bool textured, bool projector) {
    DepthImage image = wall(1.5);
    Random random(4);
    StereoSensor{.projector = projector}.measure(colors(textured), image, random);
    return std::count(image.depth.begin(), image.depth.end(), 0.0);
  };
  EXPECT_EQ(missing(true, false), 0);
  EXPECT_EQ(missing(false, true), 0);
  EXPECT_GT(missing(false, false), 2000);
}

TEST(StereoSensorTest, ObjectsGrowByUpToThreePixelsAndTakeTheirLabelsAlong) {
  DepthImage image = wall(2);
  for (std::uint32_t v = 0; v < kHeight; ++v) {
    for (std::uint32_t u = 300; u < 400; ++u) {
      image.depth[std::size_t{v} * kWidth + u] = 1;
      image.label[std::size_t{v} * kWidth + u] = 20;
    }
  }
  Random random(5);
  StereoSensor{.holes = false}.measure(colors(true), image, random);
  std::size_t grown = 0, flying = 0;
  for (std::uint32_t v = 3; v + 3 < kHeight; ++v) {
    for (std::uint32_t u = 3; u + 3 < kWidth; ++u) {
      const std::size_t i = std::size_t{v} * kWidth + u;
      const bool was_object = u >= 300 && u < 400;
      flying += image.label[i] == 0 ? 1 : 0;
      if (image.label[i] == 20) {
        ASSERT_LT(image.depth[i], 1.2);
        ASSERT_TRUE(u >= 297 && u <= 402) << u;
        grown += was_object ? 0 : 1;
      } else if (image.label[i] == 1) {
        ASSERT_GT(image.depth[i], 1.8);
        ASSERT_FALSE(was_object) << u;
      }
    }
  }
  EXPECT_GT(grown, 54U);
  EXPECT_GT(flying, 27U);
  EXPECT_LT(flying, 324U);
}

}  // namespace
}  // namespace segserve::synth
