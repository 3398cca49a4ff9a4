// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <random>
#include <vector>

#include "core/tracking/leaf_claims.hpp"
#include "gmock/gmock.h"
#include "test/core/tracking/hand_made_scene.hpp"

namespace segserve::tracking {
namespace {

TEST(LeafIndex, FindsJustTheLeavesThatAreNear) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-0.4, 0.4);
  test::HandMadeScene made;
  for (int i = 0; i < 400; ++i) made.add_row({anywhere(random), anywhere(random), 1 + anywhere(random)}, 1, {9, 9, 9});
  made.add_row({900, -900, 500}, 3, {9, 9, 9});  // far from all others
  const Segmentation segmentation = made.segmentation();
  const SceneTree scene = *SceneTree::make(segmentation, View::world(), {});
  const LeafIndex index(scene);
  std::size_t all_found = 0;
  for (int i = 0; i < 300; ++i) {
    const bool is_far = i % 10 == 0;
    const Vec3 place =
        is_far ? Vec3{900.01, -900, 500} : Vec3{anywhere(random), anywhere(random), 1 + anywhere(random)};
    const double radius = scene.leaf_radius() * (0.5 + i % 8);
    std::vector<std::uint32_t> found, expected;
    index.for_each_near(place, radius, [&](std::uint32_t leaf, double squared) {
      const Vec3 d = scene.leaf_center(leaf) - place;
      EXPECT_EQ(squared, dot(d, d));
      found.push_back(leaf);
    });
    for (std::uint32_t leaf = 0; leaf < scene.leaf_count(); ++leaf) {
      const Vec3 d = scene.leaf_center(leaf) - place;
      if (dot(d, d) <= radius * radius) expected.push_back(leaf);
    }
    std::ranges::sort(found);
    EXPECT_EQ(found, expected) << i;
    all_found += found.size();
  }
  EXPECT_GT(all_found, 100U);
}

}  // namespace
}  // namespace segserve::tracking
