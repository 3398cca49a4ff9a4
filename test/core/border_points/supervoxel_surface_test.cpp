// SPDX-License-Identifier: Apache-2.0
#include "core/border_points/supervoxel_surface.hpp"

#include <gtest/gtest.h>

#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

/// Voxels at heights of +-h over the plane z = 2 that is seen from below, as a region.
Region region_of_heights(double h) {
  Region region;
  region.voxels = 4;
  region.centroid = {0, 0, 2};
  region.normal_sum = {0, 0, -4};
  region.scatter.zz = 4 * h * h;
  return region;
}

SupervoxelSurface surface_of(const Region& region) {
  const Cloud cloud = test::random_cloud(5, 1, 2, View::camera());
  RegionGraph graph;
  graph.regions = {region};
  std::vector<SupervoxelSurface> surfaces;
  EXPECT_TRUE(find_surfaces(test::TestFrame(cloud, {.voxel_resolution = 0.005}), graph, surfaces).ok());
  return surfaces.at(0);
}

TEST(SupervoxelSurface, WeighsADistanceByTheRoughness) {
  constexpr double kEdge = 0.01;  // 5 mm at 1 m
  const SupervoxelSurface flat = surface_of(region_of_heights(0)), rough = surface_of(region_of_heights(0.4 * kEdge));
  EXPECT_DOUBLE_EQ(flat.weight, 1 / 0.1);
  EXPECT_DOUBLE_EQ(rough.weight, 1 / (0.4 + 0.1));
  const Vec3 in_front{0.3, 0, 2 - 0.5 * kEdge};
  EXPECT_NEAR(flat.misfit(in_front, kEdge), 5, 1e-9);
  EXPECT_NEAR(rough.misfit(in_front, kEdge), 1, 1e-9);
}

TEST(SupervoxelSurface, CountsADistanceBehindItHalf) {
  constexpr double kEdge = 0.01;
  EXPECT_NEAR(surface_of(region_of_heights(0)).misfit({0, 0.2, 2 + kEdge}, kEdge), 0.5, 1e-9);
  EXPECT_EQ(surface_of(region_of_heights(0)).misfit({0, 0.2, 2}, kEdge), 0);
}

TEST(SupervoxelSurface, IsNotDefinedWithoutANormal) {
  Region region = region_of_heights(0);
  EXPECT_TRUE(surface_of(region).is_defined());
  region.normal_sum = {};
  EXPECT_FALSE(surface_of(region).is_defined());
}

}  // namespace
}  // namespace segserve
