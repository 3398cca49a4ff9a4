// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/spinning_lidar.hpp"
#include "core/lab/synth/street_scene.hpp"
#include "core/math/elementary.hpp"
#include "test/core/lab/synth/checksum.hpp"

namespace segserve::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SyntheticScene make_sweep(const LidarOptions& options) {
  auto scene = make_lidar_sweep(options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

std::map<std::uint32_t, std::size_t> count(const SyntheticScene& scene) {
  std::map<std::uint32_t, std::size_t> points;
  for (const std::uint32_t label : scene.label) ++points[label];
  return points;
}

// See TabletopTest.GoldenChecksum.
TEST(LidarSweepTest, GoldenChecksum) {
  EXPECT_EQ(checksum(make_sweep({.columns = 600})), 12670387619375426922U);
  EXPECT_EQ(checksum(make_sweep({.seed = 2, .rings = 16, .columns = 600, .street = true})), 8531779723473614218U);
  EXPECT_EQ(checksum(make_sweep({.seed = 3, .rings = 64, .columns = 600, .street = true, .organized = true})),
            15129239811619545018U);
}

class LidarRingsTest : public testing::TestWithParam<std::uint32_t> {};

TEST_P(LidarRingsTest, EveryRowOfAnOrganizedSweepHasOneElevation) {
  for (const bool street : {false, true}) {
    const SyntheticScene scene = make_sweep({.rings = GetParam(), .columns = 360, .street = street, .organized = true});
    const Cloud& cloud = scene.cloud;
    ASSERT_EQ(cloud.width, 360U);
    ASSERT_EQ(cloud.height, GetParam());
    EXPECT_EQ(cloud.view, View::world(0, 0, 0));
    EXPECT_TRUE(check_shape(cloud).ok());
    const SpinningLidar lidar{.rings = GetParam()};
    for (std::uint32_t ring = 0, i = 0; ring < cloud.height; ++ring) {
      EXPECT_TRUE(ring == 0 || lidar.elevation(ring) < lidar.elevation(ring - 1));
      for (std::uint32_t column = 0; column < cloud.width; ++column, ++i) {
        if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) {
          ASSERT_EQ(scene.label[i], 0U);
          continue;
        }
        const double across = std::hypot(cloud.x[i], cloud.y[i]);
        ASSERT_NEAR(math::atan2(cloud.z[i], across), lidar.elevation(ring), 1e-5);
        const double turned = 0.5 - math::atan2(cloud.y[i], cloud.x[i]) / (2 * math::kPi);
        ASSERT_NEAR(turned * cloud.width, column + 0.5, 1e-3);
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Rings, LidarRingsTest, testing::Values(16U, 32U, 64U, 128U));

TEST(LidarSweepTest, WithoutRowsItHasTheSamePointsInOrderOfTime) {
  const SyntheticScene rows = make_sweep({.columns = 360, .street = true, .organized = true});
  const SyntheticScene points = make_sweep({.columns = 360, .street = true});
  EXPECT_EQ(points.cloud.height, 1U);
  std::size_t next = 0;
  for (std::uint32_t column = 0; column < rows.cloud.width; ++column) {
    for (std::uint32_t ring = 0; ring < rows.cloud.height; ++ring) {
      const std::size_t i = std::size_t{ring} * rows.cloud.width + column;
      if (!is_finite(rows.cloud.x[i], rows.cloud.y[i], rows.cloud.z[i])) continue;
      ASSERT_LT(next, points.cloud.size());
      ASSERT_EQ(points.cloud.x[next], rows.cloud.x[i]);
      ASSERT_EQ(points.label[next], rows.label[i]);
      ++next;
    }
  }
  EXPECT_EQ(next, points.cloud.size());
  EXPECT_FALSE(points.cloud.has_color());
}

TEST(LidarSweepTest, AStreetHasGroundFacadesAndManyThings) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto points = count(make_sweep({.seed = seed, .rings = 64, .street = true}));
    EXPECT_GT(points.at(1), 15000U);
    std::size_t facades = 0, things = 0;
    for (const auto& [label, n] : points) {
      facades += label >= 2 && label < 10 && n > 300 ? 1 : 0;
      things += label >= 20 ? 1 : 0;
      EXPECT_TRUE(label < 10 || (label % 10 == 0 && n >= 10)) << label;
    }
    EXPECT_GE(facades, 6U);
    EXPECT_GE(things, 20U);
  }
}

TEST(LidarSweepTest, TheGroundIsUnevenByCentimetersAndNothingLiesBelowIt) {
  const SyntheticScene scene = make_sweep({.rings = 64, .street = true, .noise = 0});
  double lowest = 0, highest = -10;
  for (std::size_t i = 0; i < scene.label.size(); ++i) {
    const Cloud& c = scene.cloud;
    if (scene.label[i] != kGround) {
      ASSERT_GT(c.z[i], -1.7 - 1e-3);
      continue;
    }
    if (std::hypot(c.x[i], c.y[i]) > 20) continue;
    ASSERT_NEAR(c.z[i], -1.7 + ground_height(1, c.x[i], c.y[i]), 0.01);
    lowest = std::min<double>(lowest, c.z[i]);
    highest = std::max<double>(highest, c.z[i]);
  }
  EXPECT_GT(highest - lowest, 0.04);
  EXPECT_LT(highest - lowest, 0.12);
}

TEST(LidarSweepTest, RangesHaveTheNoiseOfTheSensor) {
  const SyntheticScene ideal = make_sweep({.organized = true, .noise = 0});
  const SyntheticScene noisy = make_sweep({.organized = true});
  const auto range = [](const Cloud& c, std::size_t i) { return norm({c.x[i], c.y[i], c.z[i]}); };
  double squares = 0;
  std::size_t points = 0, lost = 0;
  for (std::size_t i = 0; i < ideal.label.size(); ++i) {
    const double error = range(noisy.cloud, i) - range(ideal.cloud, i);
    if (std::isnan(range(ideal.cloud, i))) continue;
    if (std::isnan(error)) {
      ++lost;
      continue;
    }
    squares += error * error;
    ++points;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(points)), 0.015, 0.0005);
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(points + lost), 0.01, 0.004);
}

TEST(LidarSweepTest, ARoomWithoutNoiseHasFlatWallsAndAFlatFloor) {
  const SyntheticScene scene = make_sweep({.rings = 128, .noise = 0});
  std::map<std::uint32_t, std::pair<double, double>> extent;  // of z on floor and ceiling, of y or x on walls
  for (std::size_t i = 0; i < scene.label.size(); ++i) {
    const std::uint32_t label = scene.label[i];
    if (label == 0 || label > 6) continue;
    const bool is_level = label == 1 || label == 6, faces_y = label == 2 || label == 4;
    const double value = is_level ? scene.cloud.z[i] : faces_y ? scene.cloud.y[i] : scene.cloud.x[i];
    const auto [at, is_new] = extent.try_emplace(label, value, value);
    at->second.first = std::min(at->second.first, value);
    at->second.second = std::max(at->second.second, value);
  }
  EXPECT_GE(extent.size(), 5U);
  for (const auto& [label, range] : extent) EXPECT_NEAR(range.first, range.second, 1e-4) << label;
}

TEST(LidarOptionsTest, EveryWrongOptionIsNamed) {
  const auto status = make_lidar_sweep({.rings = 17, .columns = 1, .noise = 11}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr("rings is 17, must be 16, 32, 64 or 128"),
                                                   HasSubstr("columns is 1"), HasSubstr("noise is 11")));
}

}  // namespace
}  // namespace segserve::synth
