// SPDX-License-Identifier: Apache-2.0
#include "core/scale/sweep_sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/math/random.hpp"
#include "test/core/support/sweep.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

std::optional<SweepSampling> sampling_of(const Cloud& cloud, const Options& options = {}) {
  const test::TestFrame frame(cloud, options);
  const StopToken stop;
  StopCheck check(stop);
  return estimate_sweep_sampling(frame, check);
}

TEST(SweepSampling, TellsTheAnglesBetweenRaysAndTheSlopeOfTheGround) {
  for (const double ring : {0.2, 0.4, 1.3}) {
    test::Street street{.rings = static_cast<int>(20 / ring), .ring = ring};
    const auto sampling = sampling_of(street.sweep());
    ASSERT_TRUE(sampling) << ring;
    EXPECT_NEAR(sampling->ring, ring * math::kDegree, 0.02 * ring * math::kDegree);
    EXPECT_NEAR(sampling->azimuth, 0.25 * math::kDegree, 0.01 * math::kDegree);
    EXPECT_NEAR(sampling->slope, 1 / 1.8, 0.15 / 1.8) << "1/range grows by 1/height a radian";
  }
}

TEST(SweepSampling, KnowsSectorsAndSensorsElsewhere) {
  test::Street street{.from = -60, .to = 60, .sensor = {100, -40, 7}};
  const auto sampling = sampling_of(street.sweep());
  ASSERT_TRUE(sampling);
  EXPECT_NEAR(sampling->ring, 0.4 * math::kDegree, 0.01 * math::kDegree);
}

TEST(SweepSampling, DoesNotDependOnTheOrderOfThePoints) {
  const Cloud cloud = test::Street().sweep();
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  const auto a = sampling_of(cloud), b = sampling_of(test::permuted(cloud, order));
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->ring, b->ring);
  EXPECT_EQ(a->azimuth, b->azimuth);
  EXPECT_EQ(a->slope, b->slope);
}

TEST(SweepSampling, IsNotDeceivedByOtherClouds) {
  Cloud cloud = test::Street().sweep();
  cloud.view = View::world();
  EXPECT_FALSE(sampling_of(cloud)) << "nobody knows where the sensor was";
  EXPECT_FALSE(sampling_of(test::Street{.rings = 10, .ring = 2}.sweep())) << "rings are too far apart";
  EXPECT_FALSE(sampling_of(test::random_cloud(50000, 20, 0, View::world(0, 0, 0)))) << "many surfaces a ray";
  // A ground that was scanned evenly from everywhere: most of its points are far from this sensor.
  Cloud even = test::unorganized(View::world(0, 0, 1.8F));
  Random random(4);
  for (int i = 0; i < 100000; ++i) {
    test::add(even, static_cast<float>(60 * random.uniform() - 30), static_cast<float>(60 * random.uniform() - 30), 0,
              0);
  }
  EXPECT_FALSE(sampling_of(even));
  Cloud few = test::unorganized(View::world(0, 0, 0));
  test::add_patch(few, 1, 1, 1, 0.5F, 0.1F, 0);
  EXPECT_FALSE(sampling_of(few));
}

TEST(SweepSampling, BelievesAPresetThatItIsASweep) {
  Cloud cloud = test::Street().sweep();
  cloud.view = View::world(0, 0, 0);
  // Second echoes far behind half of the points: many surfaces a ray.
  for (std::size_t i = 0, n = cloud.size(); i < n; i += 2) {
    test::add(cloud, 1.5F * cloud.x[i] + 0.001F, 1.5F * cloud.y[i], 1.5F * cloud.z[i], 0);
  }
  EXPECT_FALSE(sampling_of(cloud));
  const auto sampling = sampling_of(cloud, {.preset = Preset::kLidar});
  ASSERT_TRUE(sampling);
  EXPECT_NEAR(sampling->ring, 0.4 * math::kDegree, 0.02 * math::kDegree);
}

TEST(SweepSampling, KnowsASensorThatMovesDuringTheTurn) {
  test::Street street;
  for (const double meters : {0.05, 0.5, 1.4}) {
    street.motion = meters;
    const auto sampling = sampling_of(street.sweep());
    ASSERT_TRUE(sampling) << meters << " m a turn";
    EXPECT_NEAR(sampling->ring, 0.4 * math::kDegree, 0.02 * math::kDegree);
  }
}

TEST(SweepSampling, IsNotDeceivedByPointsThatComeTwice) {
  Cloud cloud = test::Street().sweep();
  const auto once = sampling_of(cloud);
  const std::size_t points = cloud.size();
  for (std::size_t i = 0; i < points; ++i) test::add(cloud, cloud.x[i], cloud.y[i], cloud.z[i], 0);
  const auto twice = sampling_of(cloud);
  ASSERT_TRUE(once && twice);
  EXPECT_EQ(twice->azimuth, once->azimuth);
}

TEST(SweepSampling, AFewPointsBehindOthersChangeNothing) {
  test::Street street{.azimuth = 0.35};  // so wide that a slice has one column at most
  Cloud cloud = street.sweep();
  for (std::size_t i = 0; i < 300; ++i) test::add(cloud, 3 * cloud.x[i], 3 * cloud.y[i], 3 * cloud.z[i], 0);
  EXPECT_TRUE(sampling_of(cloud));
}

TEST(SweepSampling, SurvivesPointsAtTheSensorAndAboveIt) {
  Cloud cloud = test::Street().sweep();
  for (int i = 0; i < 2000; ++i) test::add(cloud, 0, 0, i % 2 == 0 ? 0.0F : 3.0F, 0);
  EXPECT_TRUE(sampling_of(cloud));
}

TEST(SweepSampling, LooksOnlyAtPointsThatAreSelected) {
  Cloud cloud = test::Street().sweep();
  const auto alone = sampling_of(cloud);
  for (int i = 0; i < 20000; ++i) test::add(cloud, 0.01F * static_cast<float>(i % 100), 3, 9, 0);
  const auto cropped = sampling_of(cloud, {.crop_max_z = 5});
  ASSERT_TRUE(alone && cropped);
  EXPECT_EQ(cropped->ring, alone->ring);
}

}  // namespace
}  // namespace segserve
