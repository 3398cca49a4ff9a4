// SPDX-License-Identifier: Apache-2.0
#include "core/weights/border_metric.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>
#include <vector>

#include "core/math/elementary.hpp"
#include "core/merging/merger.hpp"
#include "core/weights/color_difference.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

constexpr Vec3 kFlat{0, 0, 1};
constexpr SurfaceTolerance kTolerance{.step = 0.00075, .seed = 0.03, .angle = 10};

/// A unit vector in the x-z plane, `degrees` from up towards +x.
Vec3 tilted(double degrees) { return {math::sin(degrees * math::kDegree), 0, math::cos(degrees * math::kDegree)}; }

TEST(IsCut, KeepsAPlaneTogether) {
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0.03, 0, 0}, kFlat, kTolerance));
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0, 0, 0}, kFlat, kTolerance));
}

TEST(IsCut, KeepsAConvexFoldAndCutsAConcaveOne) {
  // First the top of a box and its right side, then a floor and a wall to its right.
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0.015, 0, -0.015}, tilted(90), kTolerance));
  EXPECT_TRUE(is_cut({0, 0, 0}, kFlat, {0.015, 0, 0.015}, tilted(-90), kTolerance));
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0.03, 0, 0.001}, tilted(-8), kTolerance)) << "hardly concave";
}

TEST(IsCut, CutsAStep) {
  EXPECT_TRUE(is_cut({0, 0, 0}, kFlat, {0.02, 0, -0.02}, kFlat, kTolerance));
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0.03, 0, -0.0005}, kFlat, kTolerance)) << "within a tenth of a voxel";
}

TEST(IsCut, AllowsWhatNoiseExplains) {
  SurfaceTolerance noisy = kTolerance;
  noisy.angle = 50;
  EXPECT_TRUE(is_cut({0, 0, 0}, kFlat, {0.015, 0, 0.004}, tilted(-30), kTolerance));
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0.015, 0, 0.004}, tilted(-30), noisy));
  noisy.step = 0.03;
  EXPECT_FALSE(is_cut({0, 0, 0}, kFlat, {0.02, 0, -0.02}, kFlat, noisy));
}

TEST(IsCut, CutsWhereTheLineOfCentroidsRunsAlongTheFold) {
  // The fold is convex, but the regions lie side by side along it.
  EXPECT_TRUE(is_cut({0, 0, 0}, kFlat, {0.001, 0.03, 0}, tilted(60), kTolerance));
}

RegionGraph regions(const std::vector<double>& voxels) {
  RegionGraph graph;
  for (const double size : voxels) {
    Region region;
    region.voxels = size;
    region.points = static_cast<std::uint32_t>(10 + graph.regions.size());
    graph.regions.push_back(region);
  }
  return graph;
}

TEST(BorderMetric, WeighsEvidenceAgainstBiasAndSize) {
  BorderMetric metric(regions({11, 44, 176}), {}, 0, {});
  EXPECT_DOUBLE_EQ(metric.dissimilarity(0, 2, {4, 4 * 14.5}), 0) << "the smaller region is below the size that counts";
  EXPECT_NEAR(metric.dissimilarity(1, 2, {4, 4 * 14.5}), 0.6, 1e-12) << "one doubling";
  EXPECT_EQ(metric.dissimilarity(1, 2, {3, 7}), metric.dissimilarity(2, 1, {3, 7}));
  BorderMetric large(regions({1100, 110000, 110000}), {}, 0, {});
  EXPECT_EQ(large.dissimilarity(0, 1, {1, 10}), large.dissimilarity(1, 2, {1, 10})) << "beyond size_limit";
  metric.merge(1, 0, {});
  EXPECT_NEAR(metric.dissimilarity(1, 2, {4, 4 * 14.5}), 0.6 * std::log2(2.5), 1e-12);
  EXPECT_EQ(metric.points(1), 21U);
}

TEST(BorderMetric, RegionsOfFewVoxelsOrPointsAreTooSmall) {
  const RegionGraph graph = regions({32, 33, 33});  // They have 10, 11 and 12 points.
  const BorderMetric by_voxels(graph, {}, 0, {}), by_points(graph, {}, 12, {});
  EXPECT_TRUE(by_voxels.too_small(0));
  EXPECT_FALSE(by_voxels.too_small(1));
  EXPECT_TRUE(by_points.too_small(1));
  EXPECT_FALSE(by_points.too_small(2));
}

/// Regions of these sizes, each with an edge of so many contacts to a large one, which is the last.
BorderMetric beside_a_large_one(std::vector<double> voxels, const std::vector<double>& contacts) {
  voxels.push_back(1000);
  RegionGraph graph = regions(voxels);
  std::vector<BorderEvidence> evidence;
  for (std::uint32_t r = 0; r < contacts.size(); ++r) {
    graph.edges.push_back({r, static_cast<std::uint32_t>(contacts.size())});
    evidence.push_back({contacts[r], 0});
  }
  return {graph, std::move(evidence), 0, {}};
}

TEST(BorderMetric, ThinRegionsAreTooSmall) {
  const BorderMetric metric = beside_a_large_one({100, 100, 33}, {400, 401, 132});
  EXPECT_FALSE(metric.too_small(0)) << "four contacts for each voxel";
  EXPECT_TRUE(metric.too_small(1));
  EXPECT_FALSE(metric.too_small(2));
  EXPECT_FALSE(metric.too_small(3)) << "the large one";
}

TEST(BorderMetric, ThinRegionsThatBecomeThickAreNotTooSmall) {
  // Two strips side by side have 300 contacts with each other, and 250 each with what is around them.
  RegionGraph graph = regions({100, 100, 5000});
  graph.edges = {{0, 1}, {0, 2}, {1, 2}};
  BorderMetric metric(graph, {{300, 0}, {250, 0}, {250, 0}}, 0, {});
  EXPECT_TRUE(metric.too_small(0) && metric.too_small(1));
  metric.merge(0, 1, metric.evidence(0));
  EXPECT_FALSE(metric.too_small(0));
}

TEST(BorderMetric, AThickRegionStaysLargeEnoughWhateverJoinsIt) {
  RegionGraph graph = regions({34, 20, 5000});
  graph.edges = {{0, 1}, {0, 2}, {1, 2}};
  BorderMetric metric(graph, {{1, 0}, {135, 0}, {150, 0}}, 0, {});
  EXPECT_FALSE(metric.too_small(0));
  metric.merge(0, 1, metric.evidence(0));
  EXPECT_FALSE(metric.too_small(0)) << "though it has 285 contacts and 54 voxels";
}

TEST(BorderMetric, WeightIsTheSigmoid) {
  const BorderMetric metric(regions({1}), {}, 0, {});
  EXPECT_EQ(metric.weight(0), 0.5);
  EXPECT_NEAR(metric.weight(2), 1 / (1 + std::exp(-2.0)), 1e-15);
  EXPECT_EQ(metric.weight(1e9), 1);
  EXPECT_GE(metric.weight(-1e9), 0);
}

TEST(BorderMetric, GivesAMonotoneTreeOnAnyGraph) {
  const Cloud cloud = test::unorganized();
  const test::TestFrame frame(cloud);
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
    std::vector<BorderEvidence> evidence;
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const double pairs = 1 + pick(30);
      evidence.push_back({pairs, pairs * pick(25)});
    }
    BorderMetric metric(graph, std::move(evidence), 0, {});
    MergeTree tree;
    ASSERT_TRUE(Merger<BorderMetric>().run(frame, graph.edges, 0.5, metric, tree).ok());
    for (std::size_t row = 1; row < tree.row_count(); ++row) {
      if (tree.kind[row] == MergeKind::kJoined) break;
      ASSERT_GE(tree.weight[row], tree.weight[row - 1] * (1 - 1e-12)) << "trial " << trial << ", row " << row;
    }
  }
}

RegionGraph pair_graph() {
  RegionGraph graph;
  for (const double x : {0.0, 0.03}) {
    Region region;
    region.points = 2;
    region.centroid = {x, 0, 1};
    region.normal_sum = {0, 0, 5};
    region.color_sum = {2 * 200.0, 2 * 4000 * x, 0};
    graph.regions.push_back(region);
  }
  graph.edges = {{0, 1}};
  return graph;
}

TEST(BorderEvidence, IsTheWeightedSumOfConcavityAndColorForEachContact) {
  const Cloud cloud = test::unorganized();
  const test::TestFrame frame(cloud);
  const RegionGraph graph = pair_graph();
  const BorderConstants constants;
  std::vector<BorderEvidence> evidence;
  ASSERT_TRUE(find_border_evidence(frame, graph, {{7, 12}}, constants, evidence).ok());
  const double color = ciede2000(srgb_to_lab({200, 0, 0}), srgb_to_lab({200, 120, 0}));
  EXPECT_EQ(evidence.at(0).contacts, 7);
  EXPECT_DOUBLE_EQ(evidence[0].sum, 7 * (constants.concavity_weight * 12 + constants.color_weight * color));
}

TEST(BorderEvidence, StopsWhenAsked) {
  const Cloud cloud = test::unorganized();
  const std::atomic<bool> cancelled = true;
  const test::TestFrame frame(cloud, {}, StopToken(&cancelled));
  std::vector<BorderEvidence> evidence;
  EXPECT_EQ(find_border_evidence(frame, pair_graph(), {{7, 12}}, {}, evidence).code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
