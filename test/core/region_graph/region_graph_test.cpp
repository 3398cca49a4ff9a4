// SPDX-License-Identifier: Apache-2.0
#include "core/region_graph/region_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <utility>
#include <vector>

#include "test/core/support/supervoxel_stages.hpp"

namespace segserve {
namespace {

using test::paper_options;
using test::SupervoxelStages;
using test::TestFrame;

void expect_all_pairs(const RegionGraph& graph, const SupervoxelStages& s) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> contacts;
  for (std::uint32_t v = 0; v < s.grid.size(); ++v) {
    for (const std::uint32_t u : s.adjacency.of(v)) {
      const std::uint32_t a = s.supervoxels.supervoxel_of_voxel[v], b = s.supervoxels.supervoxel_of_voxel[u];
      if (a < b) edges.emplace(a, b);
      if (a != b && v < u) contacts.emplace_back(v, u);
    }
  }
  ASSERT_FALSE(edges.empty());
  ASSERT_EQ(graph.edges.size(), edges.size());
  EXPECT_TRUE(std::ranges::equal(graph.edges, edges, {}, [](const RegionEdge& e) { return std::pair(e.a, e.b); }));
  ASSERT_EQ(graph.contacts.size(), contacts.size());
  EXPECT_TRUE(std::ranges::equal(graph.contacts, contacts, {}, [](const Contact& c) { return std::pair(c.v, c.u); }));
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::uint32_t p = s.supervoxels.supervoxel_of_voxel[contacts[c].first];
    const std::uint32_t q = s.supervoxels.supervoxel_of_voxel[contacts[c].second];
    ASSERT_EQ(graph.edges[graph.edge_of_contact[c]], (RegionEdge{std::min(p, q), std::max(p, q)})) << c;
  }
}

TEST(RegionGraph, HoldsEachAdjacentPairOnceInOrder) {
  const Cloud cloud = test::random_cloud(20000, 0.6F, 1, View::camera());
  const TestFrame frame(cloud, paper_options());
  const SupervoxelStages s = test::run_supervoxel_stages(frame);
  expect_all_pairs(test::build_region_graph(frame, s), s);
}

TEST(RegionGraph, HoldsThePairsOfManyThousandSupervoxels) {
  const Cloud cloud = test::random_cloud(40000, 0.4F, 0, View::world());
  Options options = paper_options();
  options.seed_resolution = 0.016;
  const TestFrame frame(cloud, options);
  const SupervoxelStages s = test::run_supervoxel_stages(frame);
  ASSERT_GT(s.supervoxels.count, 4096U);
  expect_all_pairs(test::build_region_graph(frame, s), s);
}

TEST(RegionGraph, HasNothingOfTheGraphThatItsBuilderMadeBefore) {
  const Cloud large = test::random_cloud(20000, 0.6F, 1, View::camera()), small = test::two_colored_patches();
  const TestFrame large_frame(large, paper_options()), small_frame(small, paper_options());
  RegionGraphConstruction builder;
  RegionGraph graph;
  for (const TestFrame* frame : {&large_frame, &small_frame, &large_frame}) {
    const SupervoxelStages s = test::run_supervoxel_stages(*frame);
    ASSERT_TRUE(builder.run(*frame, s.grid, s.adjacency, s.normals, s.supervoxels, graph).ok());
    expect_all_pairs(graph, s);
  }
}

TEST(RegionGraph, SumsOfRegionsAreThoseOfTheirVoxelsAndSurviveMerging) {
  Cloud cloud = test::two_colored_patches();
  for (float& z : cloud.z) z += 1;
  cloud.view = View::camera();
  const TestFrame frame(cloud, paper_options());
  const SupervoxelStages s = test::run_supervoxel_stages(frame);
  const RegionGraph graph = test::build_region_graph(frame, s);
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
  EXPECT_EQ(all.color_sum, color);
  EXPECT_NEAR(norm(all.centroid - mean), 0, 1e-12);
  EXPECT_NEAR(all.scatter.xx / scatter.xx, 1, 1e-12);
  EXPECT_NEAR(all.scatter.yy / scatter.yy, 1, 1e-12);
  EXPECT_NEAR(all.scatter.xy, scatter.xy, 1e-9);
}

TEST(RegionGraph, StopsWhenAsked) {
  const Cloud cloud = test::two_colored_patches();
  const SupervoxelStages s = test::run_supervoxel_stages(TestFrame(cloud, paper_options()));
  const std::atomic<bool> cancelled = true;
  const TestFrame frame(cloud, paper_options(), StopToken(&cancelled));
  RegionGraph graph;
  EXPECT_EQ(RegionGraphConstruction().run(frame, s.grid, s.adjacency, s.normals, s.supervoxels, graph).code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
