// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/time_of_flight_sensor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace segserve::synth {
namespace {

constexpr std::uint32_t kWidth = 200, kHeight = 60;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

DepthImage wall(double depth) {
  return {kWidth, kHeight, std::vector<double>(kPixels, depth), std::vector<float>(kPixels, 1.0F),
          std::vector<std::uint32_t>(kPixels, 1)};
}

std::vector<Vec3> gray(double light) { return std::vector<Vec3>(kPixels, {light, light, light}); }

double deviation(double depth, double light) {
  DepthImage image = wall(depth);
  Random random(1);
  TimeOfFlightSensor{.holes = false}.measure(gray(light), image, random);
  double squares = 0;
  for (const double z : image.depth) squares += (z - depth) * (z - depth);
  return std::sqrt(squares / static_cast<double>(kPixels));
}

TEST(TimeOfFlightSensorTest, NoNoiseAndNoHolesChangeNothing) {
  DepthImage image = wall(2);
  Random random(1);
  TimeOfFlightSensor{.noise = 0, .holes = false}.measure(gray(0.5), image, random);
  EXPECT_EQ(image.depth, wall(2).depth);
  EXPECT_EQ(image.label, wall(2).label);
}

TEST(TimeOfFlightSensorTest, NoiseGrowsAsTheLightFades) {
  EXPECT_NEAR(deviation(2, 1), time_of_flight_noise(2, 1), 0.1 * time_of_flight_noise(2, 1));
  EXPECT_NEAR(deviation(6, 1), time_of_flight_noise(6, 1), 0.1 * time_of_flight_noise(6, 1));
  EXPECT_GT(deviation(2, 0.1), 2.5 * deviation(2, 1));
}

TEST(TimeOfFlightSensorTest, FaintSurfacesAreLost) {
  const auto missing = [](double depth, double light) {
    DepthImage image = wall(depth);
    Random random(2);
    TimeOfFlightSensor{}.measure(gray(light), image, random);
    return static_cast<std::size_t>(std::count(image.depth.begin(), image.depth.end(), 0.0));
  };
  EXPECT_EQ(missing(2, 0.1), 0U);
  EXPECT_EQ(missing(12, 0.1), kPixels);
  EXPECT_EQ(missing(12, 1), 0U);
}

TEST(TimeOfFlightSensorTest, PixelsFlyBetweenTwoSurfacesWithoutALabel) {
  DepthImage image = wall(2);
  for (std::size_t i = 0; i < kPixels; ++i) {
    if (i % kWidth >= 100) continue;
    image.depth[i] = 1;
    image.label[i] = 20;
  }
  Random random(3);
  TimeOfFlightSensor{.noise = 0.1, .holes = false}.measure(gray(0.8), image, random);
  std::size_t flying = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    const double z = image.depth[i];
    if (image.label[i] == 0) {
      ++flying;
      ASSERT_TRUE(i % kWidth == 99 || i % kWidth == 100);
      ASSERT_TRUE(z > 1.05 && z < 1.95) << z;
    } else {
      ASSERT_NEAR(z, image.label[i] == 20 ? 1 : 2, 0.02);
    }
  }
  EXPECT_NEAR(static_cast<double>(flying), 0.6 * 2 * 58, 25);
}

// Two walls meet in the middle of the image, at a right angle and 2 m away.
DepthImage corner(bool concave) {
  DepthImage image = wall(2);
  for (std::size_t i = 0; i < kPixels; ++i) {
    const double across = std::abs(static_cast<double>(i % kWidth) - 99.5) / 525;
    image.depth[i] = concave ? 2 / (1 + across) : 2 / (1 - across);
    image.incidence[i] = 0.707F;
  }
  return image;
}

TEST(TimeOfFlightSensorTest, ConcaveCornersAreRoundedAndConvexOnesAreNot) {
  for (const bool concave : {true, false}) {
    DepthImage image = corner(concave);
    const DepthImage before = image;
    Random random(4);
    TimeOfFlightSensor{.noise = 1, .holes = false}.measure(gray(1), image, random);
    double at_corner = 0, aside = 0;
    for (std::uint32_t v = 0; v < kHeight; ++v) {
      const std::size_t row = std::size_t{v} * kWidth;
      at_corner += (image.depth[row + 99] - before.depth[row + 99]) / kHeight;
      aside += (image.depth[row + 60] - before.depth[row + 60]) / kHeight;
    }
    EXPECT_NEAR(aside, 0, 0.0015);
    if (concave) {
      EXPECT_LT(at_corner, -0.005);
      EXPECT_GT(at_corner, -0.03);
    } else {
      EXPECT_NEAR(at_corner, 0, 0.0015);
    }
  }
}

}  // namespace
}  // namespace segserve::synth
