// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/scene_tree.hpp"

#include <gtest/gtest.h>

#include "segserve/segment.hpp"
#include "test/core/support/sweep.hpp"

namespace segserve::tracking {
namespace {

TEST(SceneTree, KnowsThatTheVoxelsOfASweepGrowWithTheRange) {
  const Cloud cloud = test::Street().sweep();
  const Segmentation sweep = *segment(cloud, {});
  const Segmentation cubes = *segment(cloud, {.voxel_resolution = 0.3, .seed_resolution = 1.2});
  ASSERT_EQ(sweep.resolution.reason, ResolutionReason::kSweep);
  const double radius = SceneTree::make(sweep, cloud.view, {})->leaf_radius();
  EXPECT_GT(radius, 0.3 * SceneTree::make(cubes, cloud.view, {})->leaf_radius());
  EXPECT_LT(radius, 2.0);
}

}  // namespace
}  // namespace segserve::tracking
