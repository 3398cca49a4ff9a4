// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "core/merging/merger.hpp"
#include "core/weights/border_metric.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

BorderConstants with_walls() {
  BorderConstants constants;
  constants.wall_weight = 3;
  return constants;
}

/// A region whose mean normal has a length of `flatness`.
Region region_of(double voxels, double flatness) {
  Region region;
  region.voxels = voxels;
  region.points = 10;
  region.normal_sum = {0, 0, flatness * voxels};
  return region;
}

/// By how much mean evidence of 1 makes two regions more dissimilar.
double weight_of_evidence(const BorderMetric& metric, std::uint32_t a, std::uint32_t b) {
  return metric.dissimilarity(a, b, {5, 5}) - metric.dissimilarity(a, b, {5, 0});
}

TEST(BorderMetricWalls, EvidenceCountsMoreAtAWall) {
  RegionGraph graph;
  graph.regions = {region_of(6000, 0.98), region_of(60, 1), region_of(60, 1), region_of(50000, 0.8)};
  const BorderMetric metric(graph, {}, 0, with_walls());
  EXPECT_NEAR(weight_of_evidence(metric, 0, 1), 3, 1e-12);
  EXPECT_NEAR(weight_of_evidence(metric, 1, 0), 3, 1e-12);
  EXPECT_NEAR(weight_of_evidence(metric, 1, 2), 1, 1e-12) << "neither is large";
  EXPECT_NEAR(weight_of_evidence(metric, 1, 3), 1, 1e-12) << "large, but curved";
  EXPECT_EQ(metric.dissimilarity(0, 1, {5, 0}), metric.dissimilarity(3, 1, {5, 0})) << "no evidence, nothing to weigh";
  const BorderMetric usual(graph, {}, 0, {});
  EXPECT_NEAR(weight_of_evidence(usual, 0, 1), 1, 1e-12) << "where borders are seen in part";
}

TEST(BorderMetricWalls, PartsBecomeAWallAndStayOne) {
  RegionGraph graph;
  graph.regions = {region_of(400, 1), region_of(400, 1), region_of(60, 1), region_of(900, 0), region_of(9000, 0)};
  BorderMetric metric(graph, {}, 0, with_walls());
  EXPECT_NEAR(weight_of_evidence(metric, 0, 2), 1, 1e-12);
  EXPECT_TRUE(metric.changes_all(0, 1));
  EXPECT_FALSE(metric.changes_all(0, 2));
  metric.merge(0, 1, {});
  EXPECT_NEAR(weight_of_evidence(metric, 0, 2), 3, 1e-12);
  EXPECT_FALSE(metric.changes_all(0, 2)) << "it is a wall already";
  EXPECT_TRUE(metric.changes_all(2, 0)) << "what takes over a wall becomes one";
  metric.merge(0, 3, {});
  EXPECT_NEAR(weight_of_evidence(metric, 0, 2), 3, 1e-12) << "whatever else joins it";
}

/// The border method's metric without what tells the merger which edges a merge leaves alone.
class MeasuredAnew {
 public:
  using Evidence = BorderMetric::Evidence;
  explicit MeasuredAnew(BorderMetric metric) : metric_(std::move(metric)) {}

  std::size_t region_count() const { return metric_.region_count(); }
  std::uint32_t points(std::uint32_t r) const { return metric_.points(r); }
  const Evidence& evidence(std::size_t edge) const { return metric_.evidence(edge); }
  double dissimilarity(std::uint32_t a, std::uint32_t b, const Evidence& evidence) const {
    return metric_.dissimilarity(a, b, evidence);
  }
  double weight(double dissimilarity) const { return metric_.weight(dissimilarity); }
  bool too_small(std::uint32_t r) const { return metric_.too_small(r); }
  void merge(std::uint32_t into, std::uint32_t from, const Evidence& between) { metric_.merge(into, from, between); }

 private:
  BorderMetric metric_;
};
static_assert(RegionMetric<MeasuredAnew> && !PartialRegionMetric<MeasuredAnew>);

/// A graph whose regions make walls early or late, or never.
RegionGraph random_graph(std::mt19937_64& random, std::vector<BorderEvidence>& evidence) {
  const auto pick = [&](int n) { return static_cast<double>(random() % static_cast<unsigned>(n)); };
  RegionGraph graph;
  for (int r = 0; r < 60; ++r) graph.regions.push_back(region_of(10 + pick(60), 0.8 + 0.05 * pick(5)));
  for (std::uint32_t a = 0; a < 60; ++a) {
    for (std::uint32_t b = a + 1; b < 60; ++b) {
      if (random() % 10 == 0) graph.edges.push_back({a, b});
    }
  }
  evidence.clear();
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const double contacts = 1 + pick(30);
    evidence.push_back({contacts, contacts * pick(25)});
  }
  return graph;
}

TEST(BorderMetricWalls, TheTreeIsMonotoneAndThatOfAMergeThatMeasuresAllEdgesAnew) {
  const Cloud cloud = test::unorganized();
  const test::TestFrame frame(cloud);
  std::mt19937_64 random(11);
  std::vector<BorderEvidence> evidence;
  for (int trial = 0; trial < 20; ++trial) {
    const RegionGraph graph = random_graph(random, evidence);
    BorderMetric metric(graph, evidence, 0, with_walls());
    MeasuredAnew all(metric);
    MergeTree tree, expected;
    ASSERT_TRUE(Merger<BorderMetric>().run(frame, graph.edges, 0.5, metric, tree).ok());
    ASSERT_TRUE(Merger<MeasuredAnew>().run(frame, graph.edges, 0.5, all, expected).ok());
    EXPECT_TRUE(tree == expected) << "trial " << trial;
    for (std::size_t row = 1; row < tree.row_count() && tree.kind[row] == MergeKind::kMerged; ++row) {
      ASSERT_GE(tree.weight[row], tree.weight[row - 1] * (1 - 1e-12)) << "trial " << trial << ", row " << row;
    }
  }
}

}  // namespace
}  // namespace segserve
