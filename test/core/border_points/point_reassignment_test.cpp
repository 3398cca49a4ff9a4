// SPDX-License-Identifier: Apache-2.0
#include "core/border_points/point_reassignment.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <numeric>
#include <random>

#include "core/lab/synth/scene.hpp"
#include "core/normals/edge_aware_normals.hpp"
#include "core/region_graph/borders.hpp"
#include "gmock/gmock.h"
#include "segserve/segment.hpp"
#include "test/core/support/supervoxel_stages.hpp"

namespace segserve {
namespace {

using testing::IsEmpty;

const synth::SyntheticScene& tabletop() {
  static const synth::SyntheticScene scene = [] {
    synth::SceneOptions options;
    options.seed = 4;
    options.width = 320;
    options.height = 240;
    return *synth::make_tabletop(options);
  }();
  return scene;
}

/// The stages up to the evidence, and what the reassignment makes of them.
struct Stages {
  test::SupervoxelStages s;
  std::vector<BorderEvidence> evidence;
  RegionGraph before, graph;
  std::vector<ReassignedPoint> reassigned;

  explicit Stages(const Cloud& cloud, std::uint32_t threads = 1) {
    const test::TestFrame frame(cloud, {.threads = threads});
    s = test::run_supervoxel_stages(frame);
    EXPECT_TRUE(EdgeAwareNormals().run(frame, s.grid, s.adjacency, s.normals).ok());
    EXPECT_TRUE(
        SupervoxelGrowth().run(frame, s.grid, positions(), s.adjacency, s.normals, s.seeds, s.supervoxels).ok());
    graph = before = test::build_region_graph(frame, s);
    std::vector<Border> borders;
    const BorderConstants constants;
    EXPECT_TRUE(measure_borders(frame, graph, s.grid, s.normals, constants.dead_zone, borders).ok());
    EXPECT_TRUE(find_border_evidence(frame, graph, borders, constants, evidence).ok());
    EXPECT_TRUE(run(frame).ok());
  }

  const std::vector<Vec3>& positions() const { return s.positions.empty() ? s.grid.centroid : s.positions; }
  absl::Status run(const FrameContext& frame) {
    return PointReassignment().run(frame, s.grid, positions(), s.adjacency, s.supervoxels, evidence, graph, reassigned);
  }

  /// The supervoxel of every point before the reassignment.
  std::vector<std::uint32_t> supervoxels_of_voxels() const {
    std::vector<std::uint32_t> supervoxel(s.grid.slot_of_point.size(), kNoVoxel);
    for (std::size_t i = 0; i < supervoxel.size(); ++i) {
      const std::uint32_t slot = s.grid.slot_of_point[i];
      if (slot != 0) supervoxel[i] = s.supervoxels.supervoxel_of_voxel[s.grid.voxel_of_slot[slot]];
    }
    return supervoxel;
  }
  std::vector<std::uint32_t> supervoxels_of_points() const {
    std::vector<std::uint32_t> supervoxel = supervoxels_of_voxels();
    for (const ReassignedPoint& moved : reassigned) supervoxel[moved.point] = moved.supervoxel;
    return supervoxel;
  }
};

/// The points that are not of the object that most of their supervoxel belongs to.
std::size_t points_on_the_wrong_side(const std::vector<std::uint32_t>& supervoxel,
                                     const std::vector<std::uint32_t>& truth) {
  std::map<std::uint32_t, std::map<std::uint32_t, std::size_t>> counts;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] != 0 && supervoxel[i] != kNoVoxel) ++counts[supervoxel[i]][truth[i]];
  }
  std::size_t wrong = 0;
  for (const auto& [s, objects] : counts) {
    std::size_t all = 0, most = 0;
    for (const auto& [object, points] : objects) all += points, most = std::max(most, points);
    wrong += all - most;
  }
  return wrong;
}

TEST(PointReassignment, PutsPointsOnTheRightSide) {
  const Stages stages(tabletop().cloud);
  const std::size_t before = points_on_the_wrong_side(stages.supervoxels_of_voxels(), tabletop().label);
  const std::size_t after = points_on_the_wrong_side(stages.supervoxels_of_points(), tabletop().label);
  EXPECT_LT(after, before - before / 10) << before << " before, of " << stages.reassigned.size() << " reassigned";
}

TEST(PointReassignment, KeepsTheSumsOfTheRegions) {
  const Stages stages(tabletop().cloud);
  std::vector<std::uint32_t> points(stages.graph.regions.size());
  std::vector<Vec3> color(points.size());
  const std::vector<std::uint32_t> supervoxel = stages.supervoxels_of_points();
  for (std::size_t i = 0; i < supervoxel.size(); ++i) {
    if (supervoxel[i] == kNoVoxel) continue;
    const std::uint32_t rgb = tabletop().cloud.rgb[i];
    ++points[supervoxel[i]];
    color[supervoxel[i]] +=
        {static_cast<double>(red(rgb)), static_cast<double>(green(rgb)), static_cast<double>(blue(rgb))};
  }
  for (std::size_t s = 0; s < points.size(); ++s) {
    const Region &before = stages.before.regions[s], &after = stages.graph.regions[s];
    ASSERT_EQ(after.points, points[s]);
    ASSERT_GT(after.points, 0U);
    ASSERT_EQ(after.color_sum, color[s]);
    ASSERT_EQ(after.centroid, before.centroid);
    ASSERT_EQ(after.normal_sum, before.normal_sum);
    ASSERT_EQ(after.voxels, before.voxels);
  }
}

TEST(PointReassignment, MovesPointsToNeighborsOfTheirVoxelsOnly) {
  const Stages stages(tabletop().cloud);
  ASSERT_FALSE(stages.reassigned.empty());
  const std::vector<std::uint32_t>& supervoxel = stages.s.supervoxels.supervoxel_of_voxel;
  for (const auto& [point, s] : stages.reassigned) {
    const std::uint32_t v = stages.s.grid.voxel_of_slot[stages.s.grid.slot_of_point[point]];
    ASSERT_NE(s, supervoxel[v]);
    ASSERT_TRUE(std::ranges::any_of(stages.s.adjacency.of(v), [&](std::uint32_t u) { return supervoxel[u] == s; }));
  }
}

TEST(PointReassignment, DoesNotDependOnThreadsOrOrder) {
  const Stages one(tabletop().cloud);
  for (const std::uint32_t threads : {2U, 5U}) {
    EXPECT_EQ(Stages(tabletop().cloud, threads).reassigned, one.reassigned);
  }
  std::vector<std::uint32_t> order(tabletop().cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  const std::vector<std::uint32_t> expected = one.supervoxels_of_points(),
                                   found = Stages(test::permuted(tabletop().cloud, order)).supervoxels_of_points();
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(found[i], expected[order[i]]);
}

TEST(PointReassignment, LeavesAFlatSurfaceAlone) {
  EXPECT_THAT(Stages(test::two_colored_patches()).reassigned, IsEmpty());
}

TEST(PointReassignment, LeavesNoSupervoxelWithoutPoints) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Cloud cloud = test::random_cloud(20'000, 0.2F, 1, View::camera(), seed);
    const MergeTree tree = segment(cloud, {})->tree;
    EXPECT_GT(*std::ranges::min_element(tree.leaf_points), 0U);
  }
}

TEST(PointReassignment, StopsWhenAsked) {
  Stages stages(tabletop().cloud);
  const std::atomic<bool> cancelled = true;
  const test::TestFrame frame(tabletop().cloud, {}, StopToken(&cancelled));
  EXPECT_EQ(stages.run(frame).code(), absl::StatusCode::kCancelled);
}

/// The counts of the tree, the features and the labels of whole results tell of the same points.
class BorderPoints : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Views, BorderPoints, testing::Values("camera", "world"),
                         [](const auto& param) { return std::string(param.param); });

TEST_P(BorderPoints, CountTheSameInTreeFeaturesAndLabels) {
  Cloud cloud = tabletop().cloud;
  if (GetParam() == std::string("world")) cloud.view = View::world(0, 0, 0);
  const Segmentation result = *segment(cloud, {});
  std::vector<std::uint32_t> points(result.tree.leaf_count());
  std::vector<Eigen::Vector3d> color(points.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (result.supervoxels[i] == 0) continue;
    const std::uint32_t s = result.supervoxels[i] - 1, rgb = cloud.rgb[i];
    ++points[s];
    color[s] += Eigen::Vector3d(red(rgb), green(rgb), blue(rgb));
  }
  EXPECT_EQ(result.tree.leaf_points, points);
  for (std::size_t s = 0; s < points.size(); ++s) {
    ASSERT_TRUE(result.supervoxel_features[s].color.isApprox(color[s] / points[s], 1e-12));
  }
  EXPECT_EQ(result.tree.points.back(), result.segmented_points);
  EXPECT_TRUE(check(result.tree).ok()) << check(result.tree);
  EXPECT_EQ(result.labels, *label_points(result.supervoxels, *cut_at_threshold(result.tree, 0.5)));
}

}  // namespace
}  // namespace segserve
