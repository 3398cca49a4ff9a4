// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/degrade.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace segserve::eval {
namespace {

/// A wall of points at a depth, x and y in proportion, label 1; the last point is not finite.
codec::LabeledCloud wall(float depth, std::size_t points = 20'001) {
  codec::LabeledCloud scene;
  scene.cloud.resize(points, true);
  scene.cloud.width = static_cast<std::uint32_t>(points);
  scene.cloud.height = 1;
  scene.label.assign(points, 1);
  for (std::size_t i = 0; i < points; ++i) {
    scene.cloud.x[i] = 0.25F * depth;
    scene.cloud.y[i] = -0.5F * depth;
    scene.cloud.z[i] = depth;
  }
  scene.cloud.x.back() = scene.cloud.y.back() = scene.cloud.z.back() = NAN;
  scene.label.back() = 0;
  return scene;
}

double deviation_of_z(const codec::LabeledCloud& scene, double depth) {
  double squares = 0;
  for (std::size_t i = 0; i + 1 < scene.cloud.size(); ++i) {
    squares += (scene.cloud.z[i] - depth) * (scene.cloud.z[i] - depth);
  }
  return std::sqrt(squares / static_cast<double>(scene.cloud.size() - 1));
}

TEST(Degrade, NoiseGrowsWithTheSquareOfTheDepth) {
  for (const float depth : {0.5F, 1.0F, 2.0F}) {
    codec::LabeledCloud scene = wall(depth);
    ASSERT_TRUE(degrade(scene, {.noise_mm = 5}, "scene").ok());
    EXPECT_NEAR(deviation_of_z(scene, depth), 0.005 * depth * depth, 0.0002 * depth * depth);
  }
}

TEST(Degrade, NoiseMovesPointsAlongTheirRays) {
  codec::LabeledCloud scene = wall(1);
  ASSERT_TRUE(degrade(scene, {.noise_mm = 50}, "scene").ok());
  for (std::size_t i = 0; i + 1 < scene.cloud.size(); ++i) {
    EXPECT_NEAR(scene.cloud.x[i], 0.25 * scene.cloud.z[i], 1e-6);
    EXPECT_NEAR(scene.cloud.y[i], -0.5 * scene.cloud.z[i], 1e-6);
  }
}

TEST(Degrade, InAWorldViewRaysComeFromTheSensor) {
  codec::LabeledCloud scene = wall(1);
  scene.cloud.view = View::world(0.25F, -0.5F, 3);  // right above: the rays run along z, 2 m long
  ASSERT_TRUE(degrade(scene, {.noise_mm = 5}, "scene").ok());
  EXPECT_NEAR(deviation_of_z(scene, 1), 0.02, 0.001);
  EXPECT_EQ(scene.cloud.x[0], 0.25F);
  scene.cloud.view = View::world();
  EXPECT_EQ(degrade(scene, {.noise_mm = 5}, "scene").code(), absl::StatusCode::kInvalidArgument);
}

TEST(Degrade, APointThatWouldEndBehindTheSensorIsLost) {
  codec::LabeledCloud scene = wall(100);
  ASSERT_TRUE(degrade(scene, {.noise_mm = 20}, "scene").ok());  // sigma is twice the depth
  std::size_t lost = 0;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    EXPECT_FALSE(scene.cloud.z[i] <= 0);
    EXPECT_EQ(scene.label[i] == 0, std::isnan(scene.cloud.z[i]));
    lost += scene.label[i] == 0 ? 1U : 0U;
  }
  EXPECT_NEAR(static_cast<double>(lost), 0.3085 * 20'000, 300);  // P(gaussian < -1/2)
}

TEST(Degrade, KeepsAShareOfThePointsAndDropsTheTruthOfTheOthers) {
  codec::LabeledCloud scene = wall(1);
  ASSERT_TRUE(degrade(scene, {.keep = 0.25}, "scene").ok());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    EXPECT_EQ(scene.label[i] == 0, std::isnan(scene.cloud.x[i]));
    kept += scene.label[i];
  }
  EXPECT_NEAR(static_cast<double>(kept), 5000, 200);
  EXPECT_EQ(scene.cloud.size(), 20'001U);  // an image stays an image
}

TEST(Degrade, ScalesPointsAndSensorAndRemovesColor) {
  codec::LabeledCloud scene = wall(1);
  scene.cloud.view = View::world(1, 2, 3);
  ASSERT_TRUE(degrade(scene, {.scale = 2, .color = false}, "scene").ok());
  EXPECT_EQ(scene.cloud.z[0], 2);
  EXPECT_EQ(scene.cloud.x[0], 0.5);
  EXPECT_EQ(scene.cloud.view, View::world(2, 4, 6));
  EXPECT_FALSE(scene.cloud.has_color());
}

TEST(Degrade, ScaledScenesHaveTheNoiseOfTheirNewDistance) {
  codec::LabeledCloud scene = wall(1);
  ASSERT_TRUE(degrade(scene, {.scale = 2, .noise_mm = 5}, "scene").ok());
  EXPECT_NEAR(deviation_of_z(scene, 2), 0.02, 0.001);
}

TEST(Degrade, DependsOnSeedAndNameOnly) {
  const auto noisy = [](std::string_view name, std::uint64_t seed) {
    codec::LabeledCloud scene = wall(1, 101);
    EXPECT_TRUE(degrade(scene, {.noise_mm = 5, .keep = 0.9, .seed = seed}, name).ok());
    scene.cloud.z.back() = 0;  // NaN equals nothing
    for (float& z : scene.cloud.z) z = std::isnan(z) ? 0 : z;
    return scene.cloud.z;
  };
  EXPECT_EQ(noisy("a", 1), noisy("a", 1));
  EXPECT_NE(noisy("a", 1), noisy("b", 1));
  EXPECT_NE(noisy("a", 1), noisy("a", 2));
}

TEST(Degrade, NamesEveryValueOutOfItsRange) {
  const absl::Status status = check({.scale = 0, .noise_mm = -1, .keep = 1.5});
  EXPECT_EQ(status.message(),
            "scale: 0 is not in (0, 1000]; noise-mm: -1 is not in [0, 1000]; keep: 1.5 is not in (0, 1]");
  EXPECT_FALSE(check({.scale = NAN}).ok());
  EXPECT_TRUE(check({}).ok());
}

}  // namespace
}  // namespace segserve::eval
