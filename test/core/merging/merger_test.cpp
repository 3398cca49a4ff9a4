// SPDX-License-Identifier: Apache-2.0
#include "core/merging/merger.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/weights/paper_metric.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

constexpr double kThreshold = 0.25;

/// The loop of the paper as it stands there: every iteration computes all weights and searches all edges. Where the
/// smallest weight is not below the threshold, edges of regions that are too small go first.
MergeTree merge_naively(const RegionGraph& graph, PaperMetric metric) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& [a, b] : graph.edges) edges.emplace(a, b);
  std::vector<std::uint32_t> points;
  for (const Region& region : graph.regions) points.push_back(region.points);
  MergeTreeBuilder tree(points);
  while (!edges.empty()) {
    const auto smallest_of = [&](auto&& takes_part) {
      auto best = edges.end();  // ascending ids, so the first of equal weights wins
      double smallest = 2;
      for (auto edge = edges.begin(); edge != edges.end(); ++edge) {
        const double w = metric.dissimilarity(edge->first, edge->second);
        if (w < smallest && takes_part(edge->first, edge->second)) smallest = w, best = edge;
      }
      return std::pair(smallest, best);
    };
    auto [weight, best] = smallest_of([](auto, auto) { return true; });
    if (weight >= kThreshold) {
      const auto small =
          smallest_of([&](std::uint32_t a, std::uint32_t b) { return metric.too_small(a) || metric.too_small(b); });
      if (small.second != edges.end()) best = small.second, weight = kThreshold * (1 - 1e-12);
    }
    const auto [p, q] = *best;
    tree.merge(p, q, weight);
    metric.merge(p, q);
    std::set<std::pair<std::uint32_t, std::uint32_t>> renamed;
    for (auto [a, b] : edges) {
      if (a == q) a = p;
      if (b == q) b = p;
      if (a != b) renamed.insert(std::minmax(a, b));
    }
    edges = std::move(renamed);
  }
  const StopToken never;
  StopCheck check(never);
  tree.join_components(check);
  return std::move(tree).finish();
}

/// Patches of few colors and normals on a coarse lattice, so that many weights are equal.
RegionGraph random_graph(std::mt19937_64& random, std::uint32_t regions, double density) {
  RegionGraph graph;
  const auto pick = [&](int n) { return static_cast<double>(random() % static_cast<unsigned>(n)); };
  for (std::uint32_t r = 0; r < regions; ++r) {
    Region region;
    region.voxels = 1 + pick(20);
    region.points = static_cast<std::uint32_t>(1 + pick(50));
    region.centroid = {0.05 * pick(6), 0.05 * pick(6), 1 + 0.05 * pick(3)};
    const Vec3 normal = unit({pick(3) - 1, pick(3) - 1, -1});
    region.normal_sum = region.voxels * normal;
    if (region.voxels > 3) {  // Smaller ones have no plane of their own.
      const Vec3 u = unit(cross(normal, {1, 0.5, 0})), v = cross(normal, u);
      region.scatter = 1e-4 * region.voxels * outer(u);
      region.scatter += 5e-5 * region.voxels * outer(v);
    }
    region.color_sum = region.points * Vec3{50 * pick(3), 50 * pick(3), 50 * pick(3)};
    graph.regions.push_back(region);
  }
  for (std::uint32_t a = 0; a < regions; ++a) {
    for (std::uint32_t b = a + 1; b < regions; ++b) {
      if (static_cast<double>(random() % 1000) < 1000 * density) graph.edges.push_back({a, b});
    }
  }
  return graph;
}

class MergeOracle : public testing::TestWithParam<Method> {};

TEST_P(MergeOracle, TheFastLoopEqualsTheNaiveOneMergeByMerge) {
  std::mt19937_64 random(7);
  Options options;
  options.method = GetParam();
  options.min_segment_points = 40;
  Cloud cloud;
  cloud.view = View::camera();
  const test::TestFrame frame(cloud, options);
  Merger<PaperMetric> merger;  // One merger merges all graphs, so that none may leave anything for the next.
  for (const auto& [regions, density] : {std::pair{2U, 1.0}, {40U, 0.15}, {60U, 0.02}, {60U, 0.5}, {25U, 0.0}}) {
    for (int trial = 0; trial < 4; ++trial) {
      const RegionGraph graph = random_graph(random, regions, density);
      PaperMetric metric = *PaperMetric::create(frame, graph);
      const MergeTree expected = merge_naively(graph, metric);
      MergeTree tree;
      ASSERT_TRUE(merger.run(frame, graph.edges, kThreshold, metric, tree).ok());
      EXPECT_TRUE(tree == expected) << regions << " regions, density " << density << ", trial " << trial;
      EXPECT_TRUE(check(tree).ok()) << check(tree);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllMethods, MergeOracle, testing::ValuesIn(all_methods().begin(), all_methods().end()),
                         [](const auto& param) {
                           std::string name(segserve::name(param.param));
                           std::erase(name, '-');
                           return name;
                         });

/// A metric whose weights are in a table by the numbers of the regions.
struct TableMetric {
  struct Evidence {
    int edges = 1;
    Evidence& operator+=(const Evidence& o) { return edges += o.edges, *this; }
  };
  std::vector<std::vector<double>> table;
  std::size_t region_count() const { return table.size(); }
  std::uint32_t points(std::uint32_t r) const { return 10 * (r + 1); }
  Evidence evidence(std::size_t) const { return {}; }
  double dissimilarity(std::uint32_t a, std::uint32_t b, const Evidence&) const {
    return table[std::min(a, b)][std::max(a, b)];
  }
  double weight(double dissimilarity) const { return dissimilarity; }
  bool too_small(std::uint32_t r) const { return r == small; }
  void merge(std::uint32_t into, std::uint32_t, const Evidence&) {
    if (into == small) small = kNone;
  }
  static constexpr std::uint32_t kNone = 99;
  std::uint32_t small = kNone;
};

template <RegionMetric Metric>
absl::StatusOr<MergeTree> merge(const std::vector<RegionEdge>& edges, Metric& metric, const StopToken& stop = {}) {
  const Cloud cloud;
  MergeTree tree;
  const absl::Status status = Merger<Metric>().run(test::TestFrame(cloud, {}, stop), edges, kThreshold, metric, tree);
  if (!status.ok()) return status;
  return tree;
}

TEST(Merge, NumbersNodesAsSciPyAndTakesTheSmallerIdsFirst) {
  TableMetric metric{{{0, .3, 0, 0}, {0, 0, .1, .3}, {0, 0, 0, .1}, {0, 0, 0, 0}}};
  const std::vector<RegionEdge> edges{{0, 1}, {1, 2}, {1, 3}, {2, 3}};
  const MergeTree tree = *merge(edges, metric);
  EXPECT_EQ(tree.left, (std::vector<std::uint32_t>{1, 0, 3}));
  EXPECT_EQ(tree.right, (std::vector<std::uint32_t>{2, 4, 5}));
  EXPECT_EQ(tree.weight,
            (std::vector<double>{.1, .3, 0}));  // The weight of 0-3, which was no edge before, is 0 in the table.
  EXPECT_EQ(tree.height, (std::vector<double>{.1, .3, .3}));
  EXPECT_EQ(tree.leaves, (std::vector<std::uint32_t>{2, 3, 4}));
  EXPECT_EQ(tree.points, (std::vector<std::uint32_t>{50, 60, 100}));
}

TEST(Merge, JoinsComponentsLastAndSmallestFirst) {
  TableMetric metric{std::vector(4, std::vector<double>(4, 0.2))};
  const std::vector<RegionEdge> edges{{0, 1}};
  const MergeTree tree = *merge(edges, metric);
  // The components have 30 (0 and 1), 30 (2) and 40 (3) points. The two with 30 join first.
  EXPECT_EQ(tree.kind, (std::vector{MergeKind::kMerged, MergeKind::kJoined, MergeKind::kJoined}));
  EXPECT_EQ(tree.points, (std::vector<std::uint32_t>{30, 60, 100}));
  EXPECT_EQ(tree.weight, (std::vector<double>{0.2, 1, 1}));
  EXPECT_EQ(tree.left, (std::vector<std::uint32_t>{0, 2, 3}));
  EXPECT_EQ(tree.right, (std::vector<std::uint32_t>{1, 4, 5}));
}

/// A metric whose dissimilarity is the number of initial edges that an edge has become of.
struct CountingMetric : TableMetric {
  double dissimilarity(std::uint32_t, std::uint32_t, const Evidence& evidence) const { return 0.1 * evidence.edges; }
};

TEST(Merge, AddsUpTheEvidenceOfEdgesThatBecomeOne) {
  CountingMetric metric{{std::vector(4, std::vector<double>(4))}};
  // 0-1 is first. Then 2 has two edges to the new region and 3 has one, so that 3 comes before 2.
  const MergeTree tree = *merge({{0, 1}, {0, 2}, {0, 3}, {1, 2}}, metric);
  EXPECT_EQ(tree.weight, (std::vector<double>{0.1, 0.1, 0.2}));
  EXPECT_EQ(tree.left, (std::vector<std::uint32_t>{0, 3, 2}));
}

TEST(Merge, RegionsThatAreTooSmallJoinTheirLeastDissimilarNeighborAtTheThreshold) {
  TableMetric metric{{{0, .1, .5, .6}, {0, 0, .7, .6}, {0, 0, 0, .4}, {0, 0, 0, 0}}};
  metric.small = 2;
  const MergeTree tree = *merge({{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}}, metric);
  EXPECT_EQ(tree.left, (std::vector<std::uint32_t>{0, 2, 4})) << "2 joins 3, to which it is least dissimilar";
  EXPECT_EQ(tree.right, (std::vector<std::uint32_t>{1, 3, 5}));
  EXPECT_EQ(tree.weight[0], 0.1);
  EXPECT_LT(tree.weight[1], kThreshold);
  EXPECT_NEAR(tree.weight[1], kThreshold, 1e-9);
  EXPECT_EQ(cut_at_threshold(tree, kThreshold)->segments, 2U);
}

TEST(Merge, OfNothingIsAnEmptyTree) {
  TableMetric metric;
  const MergeTree tree = *merge({}, metric);
  EXPECT_EQ(tree.leaf_count(), 0U);
  EXPECT_EQ(tree.row_count(), 0U);
}

TEST(Merge, StopsWhenAsked) {
  TableMetric metric{std::vector(4, std::vector<double>(4, 0.2))};
  const std::vector<RegionEdge> edges{{0, 1}};
  const std::atomic<bool> cancelled = true;
  EXPECT_EQ(merge(edges, metric, StopToken(&cancelled)).status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
