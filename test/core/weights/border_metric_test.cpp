#include "core/weights/border_metric.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "core/math/elementary.hpp"
#include "core/merging/merger.hpp"
#include "core/normals/two_ring_normals.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

constexpr Vec3 kUp{0, 0, 1};

/// Unit vector in the x-z plane, `degrees` from up towards +x.
Vec3 tilted(double degrees) { return {math::sin(degrees * math::kDegree), 0, math::cos(degrees * math::kDegree)}; }

TEST(IsCut, KeepsAPlaneTogether) {
  EXPECT_FALSE(is_cut({0, 0, 0}, kUp, {0.03, 0, 0}, kUp, 0.0075, 0.03));
  EXPECT_FALSE(is_cut({0, 0, 0}, kUp, {0, 0, 0}, kUp, 0.0075, 0.03));
}

TEST(IsCut, KeepsAConvexFoldAndCutsAConcaveOne) {
  // The top of a box and its right side, then a floor and a wall to its right.
  EXPECT_FALSE(is_cut({0, 0, 0}, kUp, {0.015, 0, -0.015}, tilted(90), 0.0075, 0.03));
  EXPECT_TRUE(is_cut({0, 0, 0}, kUp, {0.015, 0, 0.015}, tilted(-90), 0.0075, 0.03));
  EXPECT_FALSE(is_cut({0, 0, 0}, kUp, {0.03, 0, 0.001}, tilted(-8), 0.0075, 0.03)) << "hardly concave";
}

TEST(IsCut, CutsAStep) {
  EXPECT_TRUE(is_cut({0, 0, 0}, kUp, {0.02, 0, -0.02}, kUp, 0.0075, 0.03));
  EXPECT_FALSE(is_cut({0, 0, 0}, kUp, {0.03, 0, -0.0005}, kUp, 0.0075, 0.03)) << "within a tenth of a voxel";
}

TEST(IsCut, CutsWhereTheLineOfCentroidsRunsAlongTheFold) {
  // Convex, but side by side along the fold: singular contact.
  EXPECT_TRUE(is_cut({0, 0, 0}, kUp, {0.001, 0.03, 0}, tilted(60), 0.0075, 0.03));
}

RegionGraph regions(const std::vector<double>& areas) {
  RegionGraph graph;
  for (const double area : areas) {
    Region region;
    region.voxels = 1;
    region.points = static_cast<std::uint32_t>(10 + graph.regions.size());
    region.area = area;
    graph.regions.push_back(region);
  }
  return graph;
}

TEST(BorderMetric, WeighsEvidenceAgainstBiasAndSize) {
  BorderMetric metric(regions({4e-4, 16e-4, 64e-4}), 0, {});
  EXPECT_DOUBLE_EQ(metric.dissimilarity(0, 2, {4, 4 * 14.5}), 0) << "the smaller region is below size_area";
  EXPECT_NEAR(metric.dissimilarity(1, 2, {4, 4 * 14.5}), 0.6, 1e-12) << "one doubling";
  EXPECT_EQ(metric.dissimilarity(1, 2, {3, 7}), metric.dissimilarity(2, 1, {3, 7}));
  BorderMetric large(regions({0.04, 4, 4}), 0, {});
  EXPECT_EQ(large.dissimilarity(0, 1, {1, 10}), large.dissimilarity(1, 2, {1, 10})) << "beyond size_limit";
  metric.merge(1, 0);
  EXPECT_NEAR(metric.dissimilarity(1, 2, {4, 4 * 14.5}), 0.6 * std::log2(2.5), 1e-12);
  EXPECT_EQ(metric.points(1), 21U);
}

TEST(BorderMetric, RegionsOfLittleAreaOrFewPointsAreTooSmall) {
  const RegionGraph graph = regions({11e-4, 13e-4, 13e-4});  // of 10, 11 and 12 points
  const BorderMetric by_area(graph, 0, {}), by_points(graph, 12, {});
  EXPECT_TRUE(by_area.too_small(0));
  EXPECT_FALSE(by_area.too_small(1));
  EXPECT_TRUE(by_points.too_small(1));
  EXPECT_FALSE(by_points.too_small(2));
}

TEST(BorderMetric, WeightIsTheSigmoid) {
  const BorderMetric metric(regions({1}), 0, {});
  EXPECT_EQ(metric.weight(0), 0.5);
  EXPECT_NEAR(metric.weight(2), 1 / (1 + std::exp(-2.0)), 1e-15);
  EXPECT_EQ(metric.weight(1e9), 1);
  EXPECT_GE(metric.weight(-1e9), 0);
}

TEST(BorderMetric, GivesAMonotoneTreeOnAnyGraph) {
  std::mt19937_64 random(4);
  const auto pick = [&](int n) { return static_cast<double>(random() % static_cast<unsigned>(n)); };
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> areas;
    for (std::size_t r = 0; r < 60; ++r) areas.push_back(1e-4 * (1 + pick(40)));
    RegionGraph graph = regions(areas);
    for (std::uint32_t a = 0; a < 60; ++a) {
      for (std::uint32_t b = a + 1; b < 60; ++b) {
        if (random() % 10 == 0) graph.edges.push_back({a, b});
      }
    }
    std::vector<BorderMetric::Evidence> evidence;
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const double pairs = 1 + pick(30);
      evidence.push_back({pairs, pairs * pick(25)});
    }
    BorderMetric metric(graph, 0, {});
    const MergeTree tree = *merge_regions<BorderMetric>(graph.edges, evidence, 0.5, metric);
    for (std::size_t row = 1; row < tree.row_count(); ++row) {
      if (tree.kind[row] == MergeKind::kJoined) break;
      ASSERT_GE(tree.weight[row], tree.weight[row - 1] * (1 - 1e-12)) << "trial " << trial << ", row " << row;
    }
  }
}

TEST(MeasureBorders, EqualsAllPairsOfVoxels) {
  const Cloud cloud = test::random_cloud(6000, 0.3F, 1, View::camera());
  const test::TestFrame frame(cloud, {.voxel_resolution = 0.01});
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  Seeds seeds;
  ASSERT_TRUE(Voxelization().run(frame, grid).ok());
  ASSERT_TRUE(find_adjacency(frame, grid, adjacency).ok());
  ASSERT_TRUE(TwoRingNormals().run(frame, grid, adjacency, normals).ok());
  SeedScratch seeding;
  select_seeds(grid, cloud.view, 0.01, 0.08, seeding, seeds);
  GrowthScratch growth;
  Supervoxels s;
  const SupervoxelOptions options{0.01, 0.08, 0.2, 0.4, 1};
  ASSERT_TRUE(grow_supervoxels(grid, adjacency, normals, seeds, options, StopToken(), growth, s).ok());
  GraphScratch scratch_of_graph;
  RegionGraph graph;
  build_region_graph(grid, adjacency, normals, s, cloud.view, 0.01, StopToken(), scratch_of_graph, graph);

  struct Sum {
    double pairs = 0, angles = 0;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, Sum> expected;
  for (std::uint32_t v = 0; v < grid.size(); ++v) {
    for (const std::uint32_t u : adjacency.of(v)) {
      if (u < v || s.of_voxel[u] == s.of_voxel[v]) continue;
      Sum& sum = expected[std::minmax(s.of_voxel[u], s.of_voxel[v])];
      sum.pairs += 1;
      const bool concave = dot(normals[v] - normals[u], grid.centroid[v] - grid.centroid[u]) < 0;
      const bool defined = norm(normals[v]) > 0 && norm(normals[u]) > 0;
      const double angle = std::acos(std::clamp(dot(normals[v], normals[u]), -1.0, 1.0)) / math::kDegree;
      if (concave && defined) sum.angles += std::max(0.0, angle - 4);
    }
  }
  std::vector<Border> borders;
  measure_borders(graph, grid, normals, s, 4, StopToken(), borders);
  ASSERT_EQ(borders.size(), expected.size());
  for (std::size_t e = 0; e < borders.size(); ++e) {
    const Sum& sum = expected.at({graph.edges[e].a, graph.edges[e].b});
    EXPECT_EQ(borders[e].voxel_pairs, sum.pairs);
    EXPECT_NEAR(borders[e].concavity, sum.angles / sum.pairs, 1e-5);
  }
}

}  // namespace
}  // namespace segserve
