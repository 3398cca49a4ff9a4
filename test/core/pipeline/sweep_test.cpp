// SPDX-License-Identifier: Apache-2.0
#include "test/core/support/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <string_view>
#include <vector>

#include "segserve/segment.hpp"

namespace segserve {
namespace {

/// For each surface of the street, the label of most of its points, and their share.
struct Majority {
  std::uint32_t label = 0;
  double share = 0;
};

std::map<std::uint32_t, Majority> majorities(const test::Street& street, const Segmentation& result) {
  std::map<std::uint32_t, std::map<std::uint32_t, double>> counts;
  for (std::size_t i = 0; i < street.surface.size(); ++i) ++counts[street.surface[i]][result.labels[i]];
  std::map<std::uint32_t, Majority> result_of;
  for (const auto& [surface, labels] : counts) {
    double all = 0;
    for (const auto& [label, count] : labels) all += count;
    const auto most = std::ranges::max_element(labels, {}, [](const auto& l) { return l.second; });
    result_of[surface] = {most->first, most->second / all};
  }
  return result_of;
}

TEST(Sweep, KeepsTheGroundWholeAndCarsApart) {
  // Cars before the sensor, behind it across the seam, and 2 m before the wall.
  test::Street street{
      .boxes = {{{8, 2, -1.8F}, {12, 4, -0.3F}}, {{-12, -1, -1.8F}, {-8, 1, -0.3F}}, {{-4, 8, -1.8F}, {0, 10, -0.3F}}}};
  street.rings = 70;  // down to the ground before the cars, whose shadows part it farther away
  const Cloud cloud = street.sweep();
  const Segmentation result = *segment(cloud, {});
  EXPECT_EQ(result.resolution.reason, ResolutionReason::kSweep);
  const auto of = majorities(street, result);
  ASSERT_EQ(of.size(), 5U);
  for (const auto& [surface, majority] : of) EXPECT_GT(majority.share, 0.9) << "surface " << surface;
  for (const auto& [a, first] : of) {
    for (const auto& [b, second] : of) {
      if (a == b) continue;
      EXPECT_NE(first.label, second.label) << "surfaces " << a << " and " << b;
    }
  }
}

TEST(Sweep, APresetDecidesWhetherItIsOne) {
  test::Street street{.rings = 250, .ring = 0.15, .azimuth = 0.1, .boxes = {{{3, 2, -1.8F}, {7, 4, -0.3F}}}};
  const Cloud dense = street.sweep();
  EXPECT_NE(segment(dense, {})->resolution.reason, ResolutionReason::kSweep) << "fine cubes hold enough points";
  const Segmentation as_lidar = *segment(dense, {.preset = Preset::kLidar});
  EXPECT_EQ(as_lidar.resolution.reason, ResolutionReason::kSweep);
  EXPECT_EQ(as_lidar.unfit_preset, "");

  Cloud nowhere = test::Street().sweep();
  nowhere.view = View::world();
  EXPECT_EQ(segment(nowhere, {.preset = Preset::kLidar})->resolution.reason, ResolutionReason::kSweep);
  nowhere.view = View::world(0, 0, 0);
  EXPECT_EQ(segment(nowhere, {})->resolution.reason, ResolutionReason::kSweep);
  for (const Preset preset : {Preset::kRoom, Preset::kScan}) {
    const Segmentation cubes = *segment(nowhere, {.preset = preset});
    EXPECT_NE(cubes.resolution.reason, ResolutionReason::kSweep);
    EXPECT_EQ(cubes.unfit_preset, "");
  }
}

TEST(Sweep, APresetThatDoesNotFitIsTold) {
  const Cloud cloud = test::random_cloud(20000, 3, 0, View::world());
  const Segmentation cubes = *segment(cloud, {.preset = Preset::kLidar});
  EXPECT_NE(cubes.resolution.reason, ResolutionReason::kSweep);
  EXPECT_NE(cubes.unfit_preset.find("rings of a spinning LiDAR"), std::string_view::npos);
  Cloud frame = test::unorganized(View::camera());
  test::add_patch(frame, 0, 0, 1, 0.3F, 0.005F, 0);
  EXPECT_NE(segment(frame, {.preset = Preset::kRoom})->unfit_preset, "");
  EXPECT_EQ(segment(frame, {.preset = Preset::kTabletop})->unfit_preset, "");
  frame.view = View::world();
  const Segmentation as_frame = *segment(frame, {.preset = Preset::kTabletop});
  frame.view = View::camera();
  EXPECT_EQ(as_frame.labels, segment(frame, {})->labels);
}

TEST(Sweep, DoesNotDependOnTheOrderOfThePointsNorOnThreads) {
  test::Street street;
  const Cloud cloud = street.sweep();
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  const Segmentation once = *segment(cloud, {}), shuffled = *segment(test::permuted(cloud, order), {});
  const Segmentation threaded = *segment(cloud, {.threads = 3});
  EXPECT_EQ(threaded.labels, once.labels);
  EXPECT_EQ(shuffled.segments, once.segments);
  std::vector<std::uint32_t> back(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) back[order[i]] = shuffled.labels[i];
  EXPECT_EQ(back, once.labels);
}

TEST(Sweep, NumbersGiveCubes) {
  const Cloud cloud = test::Street().sweep();
  EXPECT_EQ(segment(cloud, {.voxel_resolution = 0.4})->resolution.reason, ResolutionReason::kGiven);
  EXPECT_NE(segment(cloud, {.seed_resolution = 2})->resolution.reason, ResolutionReason::kSweep);
  EXPECT_NE(segment(cloud, {.method = Method::kLambda})->resolution.reason, ResolutionReason::kSweep);
}

TEST(Sweep, LeavesOutRaysWithoutAnEcho) {
  Cloud cloud = test::Street().sweep();
  const std::size_t echoes = cloud.size();
  for (int i = 0; i < 500; ++i) test::add(cloud, 0, 0, 0, 0);
  const Segmentation result = *segment(cloud, {});
  EXPECT_EQ(result.zero_points, 500U);
  EXPECT_EQ(result.finite_points, echoes);
  EXPECT_EQ(result.labels.back(), 0U);
}

TEST(Sweep, LeavesOutTheHousingOfTheSensor) {
  Cloud cloud = test::Street().sweep();
  const std::uint32_t segments = segment(cloud, {})->segments;
  std::mt19937 random(5);
  const auto near = [&] { return 0.05F * (static_cast<float>(random() % 2001) / 1000.0F - 1); };
  for (int i = 0; i < 3000; ++i) test::add(cloud, near(), near(), near(), 0);
  const Segmentation result = *segment(cloud, {});
  EXPECT_EQ(result.zero_points, 3000U);
  EXPECT_EQ(result.segments, segments);
}

TEST(Sweep, ReachesAsFarAsAScannerDoes) {
  Cloud cloud = test::Street().sweep();
  const std::size_t street = cloud.size();
  for (int i = 0; i < 4000; ++i) {  // mountains, 6 km away
    test::add(cloud, 6000, static_cast<float>(20 * (i % 200)), static_cast<float>(20 * (i / 200)), 0);
  }
  const Segmentation result = *segment(cloud, {});
  EXPECT_EQ(result.points_beyond_grid, 0U);
  EXPECT_EQ(result.segmented_points, cloud.size());
  EXPECT_NE(result.labels[street], 0U);
}

TEST(Sweep, ASmallRoomKeepsItsCubes) {
  const Cloud street = test::Street().sweep();
  Cloud room = street;
  for (auto* axis : {&room.x, &room.y, &room.z}) {
    for (float& v : *axis) v *= 0.1F;
  }
  EXPECT_NE(segment(room, {})->resolution.reason, ResolutionReason::kSweep);
}

TEST(Sweep, ItsSupportPlaneCanBeRemoved) {
  test::Street street;
  const Cloud cloud = street.sweep();
  const Segmentation result = *segment(cloud, {.support_plane_distance = 0.2});
  ASSERT_TRUE(result.support_plane);
  const auto of = majorities(street, result);
  EXPECT_EQ(of.at(0).label, 0U);
  EXPECT_NE(of.at(2).label, 0U);
}

}  // namespace
}  // namespace segserve
