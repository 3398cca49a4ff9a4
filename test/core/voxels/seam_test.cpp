// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/seam.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/math/elementary.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

/// A frame that is seen as a sweep with 100 columns a turn.
class SweepFrame {
 public:
  explicit SweepFrame(const Cloud& cloud, const Options& options = {})
      : executor_(options.threads), frame(cloud, options, executor_) {
    frame.scale.voxel = math::kPi / 50;
    frame.scale.seed = 4 * frame.scale.voxel;
    frame.scale.in_proportion = true;
    frame.scale.sweep = SweepProjection{};
  }

 private:
  Executor executor_;

 public:
  FrameContext frame;
};

/// Points all around the sensor, one for each column of voxels.
Cloud ring_of(double range) {
  Cloud cloud = test::unorganized(View::world(0, 0, 0));
  for (int i = 0; i < 100; ++i) {
    const double azimuth = (i + 0.5) * math::kPi / 50;
    test::add(cloud, static_cast<float>(range * math::cos(azimuth)), static_cast<float>(range * math::sin(azimuth)),
              0.01F, 0);
  }
  return cloud;
}

TEST(Seam, MakesARingOfNeighborsOfATurn) {
  const Cloud cloud = ring_of(10);
  const SweepFrame sweep(cloud);
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  ASSERT_TRUE(Voxelization().run(sweep.frame, grid).ok());
  ASSERT_TRUE(find_adjacency(sweep.frame, grid, adjacency).ok());
  ASSERT_EQ(grid.size(), 100U);
  ASSERT_EQ(adjacency.neighbor.size(), 2 * 99U) << "the turn is open";
  ASSERT_TRUE(join_seam(sweep.frame, grid, adjacency).ok());
  EXPECT_EQ(adjacency.neighbor.size(), 2 * 100U);
  for (std::uint32_t v = 0; v < grid.size(); ++v) {
    ASSERT_EQ(adjacency.of(v).size(), 2U);
    EXPECT_TRUE(std::ranges::is_sorted(adjacency.of(v)));
    for (const std::uint32_t u : adjacency.of(v)) EXPECT_TRUE(std::ranges::binary_search(adjacency.of(u), v));
  }
}

TEST(Seam, LeavesOtherCloudsAlone) {
  const Cloud cloud = ring_of(10);
  const test::TestFrame frame(cloud, {.voxel_resolution = 0.5});
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  ASSERT_TRUE(Voxelization().run(frame, grid).ok());
  ASSERT_TRUE(find_adjacency(frame, grid, adjacency).ok());
  const std::vector<std::uint32_t> before = adjacency.neighbor;
  ASSERT_TRUE(join_seam(frame, grid, adjacency).ok());
  EXPECT_EQ(adjacency.neighbor, before);
}

TEST(SweepCells, LieInTheDirectionOfTheirPoints) {
  const Cloud cloud = ring_of(10);
  const SweepFrame sweep(cloud);
  VoxelGrid grid;
  ASSERT_TRUE(Voxelization().run(sweep.frame, grid).ok());
  for (std::size_t v = 0; v < grid.size(); ++v) {
    const Vec3 position = (1 / sweep.frame.scale.voxel) * to_voxel_space(sweep.frame.scale, grid.centroid[v]);
    EXPECT_NEAR(position.x, static_cast<double>(v) - 50 + 0.5, 0.01);
    EXPECT_NEAR(norm(grid.centroid[v]), 10, 0.001);
  }
}

TEST(SweepCells, CountRaysWithoutAnEchoAndPointsThatAreNotSelected) {
  Cloud cloud = ring_of(10);
  test::add(cloud, 0, 0, 0, 0);
  test::add(cloud, 0, 0, 0, 0);
  test::add(cloud, NAN, 0, 0, 0);
  test::add(cloud, 1e9F, 0, 0, 0);
  const SweepFrame all(cloud), half(cloud, {.crop_min_x = 0});
  VoxelGrid grid;
  ASSERT_TRUE(Voxelization().run(all.frame, grid).ok());
  EXPECT_EQ(grid.zero_points, 2U);
  EXPECT_EQ(grid.points_beyond_grid, 1U);
  EXPECT_EQ(grid.finite_points, 101U);
  EXPECT_EQ(grid.size(), 100U);
  ASSERT_TRUE(Voxelization().run(half.frame, grid).ok());
  EXPECT_EQ(grid.size(), 50U);
  EXPECT_EQ(grid.finite_points, 101U);
}

}  // namespace
}  // namespace segserve
