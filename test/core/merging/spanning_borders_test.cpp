// SPDX-License-Identifier: Apache-2.0
#include "core/merging/spanning_borders.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "core/math/random.hpp"
#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

constexpr std::uint32_t kWood = 0x906030, kDarkWood = 0x805020, kBlue = 0x2030A0, kGray = 0x808080;
constexpr float kSpacing = 0.008F;

/// A scene as a scanner sees it that went around it. Things are numbered from 1 on.
struct Scene {
  Cloud cloud = test::unorganized(View::world());
  std::vector<std::uint32_t> thing_of_point;
  Random random{5};

  /// A plate along two axes: points at low + a * u + b * v for a and b from 0 to 1, meters.
  void add_plate(std::uint32_t thing, Eigen::Vector3f low, Eigen::Vector3f u, Eigen::Vector3f v, std::uint32_t rgb) {
    const auto steps = [](const Eigen::Vector3f& side) { return static_cast<int>(side.norm() / kSpacing); };
    for (int i = 0; i < steps(u); ++i) {
      for (int j = 0; j < steps(v); ++j) {
        const auto noise = static_cast<float>(0.0005 * random.gaussian());
        const Eigen::Vector3f p = low + (static_cast<float>(i) + 0.5F) / static_cast<float>(steps(u)) * u +
                                  (static_cast<float>(j) + 0.5F) / static_cast<float>(steps(v)) * v +
                                  noise * u.cross(v).normalized();
        test::add(cloud, p.x(), p.y(), p.z(), rgb);
        thing_of_point.push_back(thing);
      }
    }
  }

  /// A floor that is far away from the things, so that each of them is a small part of the scene.
  void add_floor() { add_plate(1, {-3, -3, -1}, {2.2F, 0, 0}, {0, 2.2F, 0}, kGray); }

  /// The segment that has most of the points of each thing, by the thing.
  std::map<std::uint32_t, std::uint32_t> segments(const Options& options = {}) const {
    const Segmentation result = segment(cloud, options).value();
    std::map<std::uint32_t, std::map<std::uint32_t, int>> counts;
    for (std::size_t i = 0; i < cloud.size(); ++i) ++counts[thing_of_point[i]][result.labels[i]];
    std::map<std::uint32_t, std::uint32_t> most;
    for (const auto& [thing, of_segment] : counts) {
      most[thing] = std::ranges::max_element(of_segment, {}, [](const auto& count) { return count.second; })->first;
    }
    return most;
  }
};

/// The seat and the back of a chair, which are things 2 and 3.
Scene chair(std::uint32_t seat_rgb, std::uint32_t back_rgb) {
  Scene scene;
  scene.add_floor();
  scene.add_plate(2, {0, 0, 0}, {0.4F, 0, 0}, {0, 0.4F, 0}, seat_rgb);
  scene.add_plate(3, {0, 0.4F, 0}, {0.4F, 0, 0}, {0, 0, 0.45F}, back_rgb);
  return scene;
}

/// Whether things 2 and 3 are one segment.
bool are_one(const Scene& scene, const Options& options = {}) {
  const auto segments = scene.segments(options);
  return segments.at(2) == segments.at(3);
}

TEST(SpanningBorders, TheSeatAndTheBackOfAChairAreOneThing) {
  for (const auto back : {kWood, kDarkWood}) {
    const auto segments = chair(kWood, back).segments();
    EXPECT_EQ(segments.at(2), segments.at(3));
    EXPECT_NE(segments.at(1), segments.at(2));
  }
}

TEST(SpanningBorders, ThePartsComeApartAtALowerThreshold) {
  EXPECT_FALSE(are_one(chair(kWood, kWood), {.threshold = 0.1}));
}

TEST(SpanningBorders, ThingsOfDifferentColorsStayApart) { EXPECT_FALSE(are_one(chair(kWood, kBlue))); }

TEST(SpanningBorders, WhatStandsOnAPartOfAnotherThingStaysApart) {
  Scene scene;
  scene.add_floor();
  scene.add_plate(2, {0, 0, 0}, {0.6F, 0, 0}, {0, 0.4F, 0}, kWood);
  scene.add_plate(3, {0.2F, 0.2F, 0}, {0.2F, 0, 0}, {0, 0, 0.25F}, kWood);
  EXPECT_FALSE(are_one(scene));
}

TEST(SpanningBorders, LargePartsOfASceneStayApart) {
  Scene scene;  // The seat and the back alone are walls, as far as anyone can tell.
  scene.add_plate(2, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, kWood);
  scene.add_plate(3, {0, 2, 0}, {2, 0, 0}, {0, 0, 2}, kWood);
  EXPECT_FALSE(are_one(scene));
}

TEST(SpanningBorders, APartBringsTogetherWhatItMeets) {
  // A shelf of two sides and a board between them.
  Scene scene;
  scene.add_floor();
  scene.add_plate(2, {0, 0, 0}, {0, 0.3F, 0}, {0, 0, 0.6F}, kWood);
  scene.add_plate(3, {0.4F, 0, 0}, {0, 0.3F, 0}, {0, 0, 0.6F}, kWood);
  scene.add_plate(4, {0, 0, 0.3F}, {0.4F, 0, 0}, {0, 0.3F, 0}, kWood);
  const auto segments = scene.segments();
  EXPECT_EQ(segments.at(2), segments.at(4));
  EXPECT_EQ(segments.at(3), segments.at(4));
}

TEST(SpanningBorders, WithoutColorTheyCountWhereNoSensorIsKnown) {
  Scene scene = chair(kWood, kWood);
  scene.cloud.rgb.clear();
  EXPECT_TRUE(are_one(scene));
  scene.cloud.view = View::world(0.2F, -2, 1);
  EXPECT_FALSE(are_one(scene));
}

TEST(SpanningBorders, TheOrderOfThePointsDoesNotMatter) {
  Scene scene = chair(kWood, kDarkWood);
  const Segmentation before = segment(scene.cloud, {}).value();
  Cloud& cloud = scene.cloud;
  std::ranges::reverse(cloud.x);
  std::ranges::reverse(cloud.y);
  std::ranges::reverse(cloud.z);
  std::ranges::reverse(cloud.rgb);
  Segmentation after = segment(cloud, {}).value();
  std::ranges::reverse(after.labels);
  EXPECT_EQ(before.labels, after.labels);
  EXPECT_EQ(before.tree, after.tree);
}

TEST(SpanningBorders, TheTreeCountsThePointsOfItsSegments) {
  for (const std::uint32_t least : {0U, 50U}) {
    const Scene scene = chair(kWood, kDarkWood);
    const Segmentation result = segment(scene.cloud, {.min_segment_points = least}).value();
    EXPECT_TRUE(check(result.tree).ok()) << check(result.tree);
    std::vector<std::uint32_t> points(result.tree.leaf_count());
    for (const std::uint32_t s : result.supervoxels) ++points.at(s - 1);
    EXPECT_EQ(points, result.tree.leaf_points);
  }
}

}  // namespace
}  // namespace segserve
