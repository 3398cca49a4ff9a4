#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/normals/two_ring_normals.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/growth.hpp"
#include "core/supervoxels/seeds.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

struct Stages {
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  Seeds seeds;
  Supervoxels supervoxels;
};

constexpr SupervoxelOptions kPaper{0.008, 0.08, 0.2, 0.4, 1};

Stages run(const Cloud& cloud, const SupervoxelOptions& options = kPaper) {
  const test::TestFrame frame(cloud, {.voxel_resolution = options.voxel_resolution});
  Stages s;
  EXPECT_TRUE(Voxelization().run(frame, s.grid).ok());
  EXPECT_TRUE(find_adjacency(frame, s.grid, s.adjacency).ok());
  EXPECT_TRUE(TwoRingNormals().run(frame, s.grid, s.adjacency, s.normals).ok());
  SeedScratch seeding;
  select_seeds(s.grid, cloud.view, options.voxel_resolution, options.seed_resolution, seeding, s.seeds);
  GrowthScratch growth;
  EXPECT_TRUE(
      grow_supervoxels(s.grid, s.adjacency, s.normals, s.seeds, options, StopToken(), growth, s.supervoxels).ok());
  return s;
}

Cloud two_colored_patches() {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0.004F, 0.4F, 0.004F, 0xff0000);
  test::add_patch(cloud, 0.4F, 0, 0.004F, 0.4F, 0.004F, 0x0000ff);
  return cloud;
}

void expect_partition(const Stages& s) {
  ASSERT_EQ(s.supervoxels.of_voxel.size(), s.grid.size());
  std::uint32_t next = 0;  // numbered in the order of their smallest voxels, without gaps
  for (const std::uint32_t id : s.supervoxels.of_voxel) {
    ASSERT_LE(id, next);
    if (id == next) ++next;
  }
  EXPECT_EQ(next, s.supervoxels.count);
}

TEST(Seeds, AreDistinctAndOneACell) {
  for (const View& view : {View::camera(), View::world()}) {
    const Stages s = run(test::random_cloud(20000, 0.6F, 1, view));
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
  const Stages s = run(cloud);
  EXPECT_GE(s.seeds.chosen.size(), 25U);
  ASSERT_EQ(s.seeds.sparse.size(), 1U) << "the single point";
  EXPECT_EQ(s.grid.centroid[s.seeds.sparse[0]].x, 2);
}

TEST(Seeds, AreFoundFarAwayToo) {
  // At 9 m a voxel of the CAMERA view is 72 mm wide; by its nominal 8 mm there would be no seed at all.
  Cloud cloud = test::unorganized(View::camera());
  for (int i = -100; i < 100; ++i) {
    for (int j = -100; j < 100; ++j)
      test::add(cloud, 0.02F * static_cast<float>(i), 0.02F * static_cast<float>(j), 9, 0);
  }
  const Stages s = run(cloud);
  EXPECT_GT(s.seeds.chosen.size(), 100U);
  EXPECT_GT(s.supervoxels.count, 100U);
}

TEST(Growth, GivesEveryVoxelToExactlyOneSupervoxel) {
  expect_partition(run(two_colored_patches()));
  expect_partition(run(test::random_cloud(20000, 0.6F, 1, View::camera())));
  expect_partition(run(test::random_cloud(300, 3, 0, View::world())));  // hundreds of components
}

TEST(Growth, ReachesWhatPclLeavesOut) {
  // A line much longer than 1.8 seed resolutions has no seed of enough area, hence no supervoxel in PCL.
  Cloud cloud = test::unorganized();
  for (int i = 0; i < 1000; ++i) test::add(cloud, 0.002F * static_cast<float>(i), 0, 0, 0);
  const Stages s = run(cloud);
  expect_partition(s);
  EXPECT_GE(s.supervoxels.count, 10U);
}

TEST(Growth, KeepsComponentsApart) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0, 0.05F, 0.004F, 0xffffff);
  test::add_patch(cloud, 0.1F, 0, 0, 0.05F, 0.004F, 0xffffff);  // in the seed cell of the first, in part
  const Stages s = run(cloud);
  std::set<std::uint32_t> left, right;
  for (std::size_t v = 0; v < s.grid.size(); ++v) {
    (s.grid.centroid[v].x < 0.07 ? left : right).insert(s.supervoxels.of_voxel[v]);
  }
  std::vector<std::uint32_t> both;
  std::ranges::set_intersection(left, right, std::back_inserter(both));
  EXPECT_TRUE(both.empty());
}

TEST(Growth, FollowsColorsWhenTheyWeigh) {
  const Stages s = run(two_colored_patches(), {0.008, 0.08, 1, 0.1, 1});
  std::vector<std::set<bool>> colors(s.supervoxels.count);
  for (std::size_t v = 0; v < s.grid.size(); ++v) {
    if (s.grid.color_sum[v].x > 0 && s.grid.color_sum[v].z > 0) continue;  // a voxel across the border
    colors[s.supervoxels.of_voxel[v]].insert(s.grid.color_sum[v].x > 0);
  }
  for (const auto& set : colors) EXPECT_LE(set.size(), 1U);
}

void expect_each_adjacent_pair_once(const Stages& s, const View& view) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
  for (std::uint32_t v = 0; v < s.grid.size(); ++v) {
    for (const std::uint32_t u : s.adjacency.of(v)) {
      const std::uint32_t a = s.supervoxels.of_voxel[v], b = s.supervoxels.of_voxel[u];
      if (a < b) expected.emplace(a, b);
    }
  }
  ASSERT_FALSE(expected.empty());
  GraphScratch scratch;
  RegionGraph graph;
  build_region_graph(s.grid, s.adjacency, s.normals, s.supervoxels, view, 0.008, StopToken(), scratch, graph);
  ASSERT_EQ(graph.edges.size(), expected.size());
  EXPECT_TRUE(std::ranges::equal(graph.edges, expected, {}, [](const RegionEdge& e) { return std::pair(e.a, e.b); }));
}

TEST(RegionGraph, HoldsEachAdjacentPairOnceInOrder) {
  expect_each_adjacent_pair_once(run(test::random_cloud(20000, 0.6F, 1, View::camera())), View::camera());
}

TEST(RegionGraph, HoldsEachAdjacentPairOfManyThousandsInOrder) {
  const Stages s = run(test::random_cloud(40000, 0.4F, 0, View::world()), {0.008, 0.016, 0.2, 0.4, 1});
  ASSERT_GT(s.supervoxels.count, 4096U) << "edges of few regions are found in another way";
  expect_each_adjacent_pair_once(s, View::world());
}

TEST(RegionGraph, SumsOfRegionsAreThoseOfTheirVoxelsAndSurviveMerging) {
  const Stages s = run(two_colored_patches());
  GraphScratch scratch;
  RegionGraph graph;
  build_region_graph(s.grid, s.adjacency, s.normals, s.supervoxels, View::camera(), 0.008, StopToken(), scratch, graph);
  Region all = graph.regions[0];
  for (std::size_t r = 1; r < graph.regions.size(); ++r) all.merge(graph.regions[r]);
  Vec3 mean, color;
  Symmetric3 scatter;
  for (const Vec3& c : s.grid.centroid) mean += c;
  mean = (1.0 / static_cast<double>(s.grid.size())) * mean;
  for (const Vec3& c : s.grid.centroid) scatter += outer(c - mean);
  for (const Vec3& c : s.grid.color_sum) color += c;
  EXPECT_EQ(all.voxels, static_cast<double>(s.grid.size()));
  EXPECT_EQ(all.points, s.grid.finite_points);
  double area = 0;
  for (const Vec3& c : s.grid.centroid) area += 0.008 * c.z * 0.008 * c.z;
  EXPECT_NEAR(all.area / area, 1, 1e-12) << "in a CAMERA view a voxel is as large as its distance makes it";
  EXPECT_EQ(all.color_sum, color);
  EXPECT_NEAR(norm(all.centroid - mean), 0, 1e-12);
  EXPECT_NEAR(all.scatter.xx / scatter.xx, 1, 1e-12);
  EXPECT_NEAR(all.scatter.yy / scatter.yy, 1, 1e-12);
  EXPECT_NEAR(all.scatter.xy, scatter.xy, 1e-9);
}

}  // namespace
}  // namespace segserve
