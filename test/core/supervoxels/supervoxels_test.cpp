// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <set>
#include <vector>

#include "core/supervoxels/seed_selection.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "test/core/support/supervoxel_stages.hpp"

namespace segserve {
namespace {

using test::SupervoxelStages;
using test::TestFrame;

SupervoxelStages run(const Cloud& cloud, const Options& options = test::paper_options()) {
  return test::run_supervoxel_stages(TestFrame(cloud, options));
}

void expect_partition(const SupervoxelStages& s) {
  ASSERT_EQ(s.supervoxels.supervoxel_of_voxel.size(), s.grid.size());
  std::uint32_t next = 0;  // They are numbered in the order of their smallest voxels, without gaps.
  for (const std::uint32_t id : s.supervoxels.supervoxel_of_voxel) {
    ASSERT_LE(id, next);
    if (id == next) ++next;
  }
  EXPECT_EQ(next, s.supervoxels.count);
}

TEST(Seeds, AreDistinctAndOneACell) {
  for (const View& view : {View::camera(), View::world()}) {
    const SupervoxelStages s = run(test::random_cloud(20000, 0.6F, 1, view));
    std::set<std::uint32_t> distinct(s.seeds.chosen.begin(), s.seeds.chosen.end());
    distinct.insert(s.seeds.sparse.begin(), s.seeds.sparse.end());
    EXPECT_EQ(distinct.size(), s.seeds.chosen.size() + s.seeds.sparse.size());
    EXPECT_FALSE(s.seeds.chosen.empty());
  }
}

TEST(Seeds, LieOnSurfacesOfEnoughArea) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0, 0.4F, 0.004F, 0);
  test::add(cloud, 2, 2, 2, 0);
  const SupervoxelStages s = run(cloud);
  EXPECT_GE(s.seeds.chosen.size(), 25U);
  ASSERT_EQ(s.seeds.sparse.size(), 1U) << "the single point";
  EXPECT_EQ(s.grid.centroid[s.seeds.sparse[0]].x, 2);
}

TEST(Seeds, AreFoundFarAwayToo) {
  // At 9 m a voxel of the CAMERA view is 72 mm wide. By its nominal 8 mm there would be no seed at all.
  Cloud cloud = test::unorganized(View::camera());
  for (int i = -100; i < 100; ++i) {
    for (int j = -100; j < 100; ++j) {
      test::add(cloud, 0.02F * static_cast<float>(i), 0.02F * static_cast<float>(j), 9, 0);
    }
  }
  const SupervoxelStages s = run(cloud);
  EXPECT_GT(s.seeds.chosen.size(), 100U);
  EXPECT_GT(s.supervoxels.count, 100U);
}

TEST(Seeds, SelectionStopsWhenAsked) {
  const Cloud cloud = test::two_colored_patches();
  const SupervoxelStages s = run(cloud);
  const std::atomic<bool> cancelled = true;
  const TestFrame frame(cloud, test::paper_options(), StopToken(&cancelled));
  Seeds seeds;
  EXPECT_EQ(SeedSelection().run(frame, s.grid.centroid, seeds).code(), absl::StatusCode::kCancelled);
}

TEST(Growth, AssignsEveryVoxelToExactlyOneSupervoxel) {
  expect_partition(run(test::two_colored_patches()));
  expect_partition(run(test::random_cloud(20000, 0.6F, 1, View::camera())));
  expect_partition(run(test::random_cloud(300, 3, 0, View::world())));  // hundreds of components
}

TEST(Growth, ReachesVoxelsThatPclLeavesOut) {
  // A line much longer than 1.8 seed resolutions has no seed of enough area, hence no supervoxel in PCL.
  Cloud cloud = test::unorganized();
  for (int i = 0; i < 1000; ++i) test::add(cloud, 0.002F * static_cast<float>(i), 0, 0, 0);
  const SupervoxelStages s = run(cloud);
  expect_partition(s);
  EXPECT_GE(s.supervoxels.count, 10U);
}

TEST(Growth, KeepsComponentsApart) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0, 0.05F, 0.004F, 0xffffff);
  test::add_patch(cloud, 0.1F, 0, 0, 0.05F, 0.004F, 0xffffff);  // partly in the seed cell of the first
  const SupervoxelStages s = run(cloud);
  std::set<std::uint32_t> left, right;
  for (std::size_t v = 0; v < s.grid.size(); ++v) {
    (s.grid.centroid[v].x < 0.07 ? left : right).insert(s.supervoxels.supervoxel_of_voxel[v]);
  }
  std::vector<std::uint32_t> both;
  std::ranges::set_intersection(left, right, std::back_inserter(both));
  EXPECT_TRUE(both.empty());
}

TEST(Growth, FollowsColorsIfTheyHaveWeight) {
  Options options = test::paper_options();
  options.color_weight = 1;
  options.spatial_weight = 0.1;
  const SupervoxelStages s = run(test::two_colored_patches(), options);
  std::vector<std::set<bool>> colors(s.supervoxels.count);
  for (std::size_t v = 0; v < s.grid.size(); ++v) {
    if (s.grid.color_sum[v].x > 0 && s.grid.color_sum[v].z > 0) continue;  // a voxel across the border
    colors[s.supervoxels.supervoxel_of_voxel[v]].insert(s.grid.color_sum[v].x > 0);
  }
  for (const auto& set : colors) EXPECT_LE(set.size(), 1U);
}

TEST(Growth, GivesTheSameSupervoxelsWithTheBuffersOfOtherFrames) {
  const Cloud large = test::random_cloud(20000, 0.6F, 1, View::camera()), small = test::two_colored_patches();
  const TestFrame large_frame(large, test::paper_options()), small_frame(small, test::paper_options());
  SeedSelection selector;
  SupervoxelGrowth grower;
  for (const TestFrame* frame : {&large_frame, &small_frame, &large_frame}) {
    const SupervoxelStages expected = test::run_supervoxel_stages(*frame);
    Seeds seeds;
    Supervoxels supervoxels;
    ASSERT_TRUE(selector.run(*frame, expected.grid.centroid, seeds).ok());
    ASSERT_TRUE(grower
                    .run(*frame, expected.grid, expected.grid.centroid, expected.adjacency, expected.normals, seeds,
                         supervoxels)
                    .ok());
    EXPECT_EQ(seeds.chosen, expected.seeds.chosen);
    EXPECT_EQ(supervoxels.supervoxel_of_voxel, expected.supervoxels.supervoxel_of_voxel);
  }
}

TEST(Growth, StopsWhenAsked) {
  const Cloud cloud = test::two_colored_patches();
  const SupervoxelStages s = run(cloud);
  const std::atomic<bool> cancelled = true;
  const TestFrame frame(cloud, test::paper_options(), StopToken(&cancelled));
  Supervoxels supervoxels;
  EXPECT_EQ(SupervoxelGrowth().run(frame, s.grid, s.grid.centroid, s.adjacency, s.normals, s.seeds, supervoxels).code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
