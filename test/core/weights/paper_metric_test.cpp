// SPDX-License-Identifier: Apache-2.0
#include "core/weights/paper_metric.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "core/weights/color_difference.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

constexpr Vec3 kUp{0, 0, 1};
constexpr Vec3 kSide{1, 0, 0};

TEST(GeometricTerm, IsZeroForCoplanarRegions) { EXPECT_EQ(geometric_term({0, 0, 0}, kUp, {1, 2, 0}, kUp), 0); }

TEST(GeometricTerm, IsEquation5) {
  // The normals are orthogonal and the centroids on the line of the first normal: (1 + 1 + 0) / 3.
  EXPECT_DOUBLE_EQ(geometric_term({0, 0, 0}, kUp, {0, 0, 2}, kSide), 2.0 / 3);
  const double h = std::sqrt(0.5);
  EXPECT_NEAR(geometric_term({0, 0, 0}, kUp, {1, 0, -1}, kSide), (1 + h + h) / 3, 1e-15);
}

TEST(GeometricTerm, IsDefinedWhereCentroidsCoincide) {
  EXPECT_DOUBLE_EQ(geometric_term({1, 1, 1}, kUp, {1, 1, 1}, kSide), 1.0 / 3);
  EXPECT_EQ(geometric_term({1, 1, 1}, kUp, {1, 1, 1}, kUp), 0);
}

TEST(Convexity, IsThatOfABoxEdgeAndNotOfACorner) {
  // First the top and a side of a box, seen from outside, then a floor and a wall.
  const auto share = [](const Vec3& xi, const Vec3& xj) {
    return geometric_term(xi, kUp, xj, kSide, true) / geometric_term(xi, kUp, xj, kSide);
  };
  EXPECT_EQ(share({0, 0, 0}, {0.5, 0, -0.5}), 0.5);
  EXPECT_EQ(share({0, 0, 0}, {-0.5, 0, 0.5}), 1);
}

/// A flat square region of 3 x 3 voxels of one color, orthogonal to z or to x.
Region square(const Vec3& center, bool vertical, const Vec3& rgb, std::uint32_t points = 9) {
  Region region;
  region.voxels = 9;
  region.points = points;
  region.centroid = center;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      region.scatter += outer(vertical ? Vec3{0, 0.01 * i, 0.01 * j} : Vec3{0.01 * i, 0.01 * j, 0});
    }
  }
  region.normal_sum = 9 * (vertical ? kSide : kUp);
  region.color_sum = points * rgb;
  return region;
}

RegionGraph step_graph() {
  RegionGraph graph;
  graph.regions = {square({0, 0, 0}, false, {200, 10, 10}), square({0.03, 0, 0}, false, {200, 10, 10}),
                   square({0.05, 0, 0.02}, true, {10, 10, 200})};
  graph.edges = {{0, 1}, {1, 2}};
  return graph;
}

PaperMetric metric_of(const RegionGraph& graph, const View& view, const Options& options) {
  Cloud cloud;
  cloud.view = view;
  return *PaperMetric::create(test::TestFrame(cloud, options), graph);
}

double weight(Method method, double lambda, std::uint32_t a, std::uint32_t b) {
  Options options;
  options.method = method;
  options.lambda = lambda;
  return metric_of(step_graph(), View::world(-1, 0, 1), options).dissimilarity(a, b);
}

TEST(PaperMetric, FixedLambdaSpansColorAndGeometry) {
  EXPECT_DOUBLE_EQ(weight(Method::kFixedLambda, 1, 1, 2), weight(Method::kColor, 0.5, 1, 2));
  EXPECT_DOUBLE_EQ(weight(Method::kFixedLambda, 0, 1, 2), weight(Method::kGeometry, 0.5, 1, 2));
  EXPECT_DOUBLE_EQ(weight(Method::kFixedLambda, 0.5, 1, 2),
                   0.5 * weight(Method::kColor, 0, 1, 2) + 0.5 * weight(Method::kGeometry, 0, 1, 2));
}

TEST(PaperMetric, CoplanarRegionsOfOneColorAreAlike) {
  for (const Method method : {Method::kColor, Method::kGeometry, Method::kLambda, Method::kLambdaConvex}) {
    EXPECT_NEAR(weight(method, 0.5, 0, 1), 0, 1e-12) << name(method);
    EXPECT_GT(weight(method, 0.5, 1, 2), 0.1) << name(method);
  }
}

TEST(PaperMetric, LearningStopsWhenAsked) {
  const Cloud cloud;
  const std::atomic<bool> cancelled = true;
  const test::TestFrame frame(cloud, {.method = Method::kLambda}, StopToken(&cancelled));
  EXPECT_EQ(PaperMetric::create(frame, step_graph()).status().code(), absl::StatusCode::kCancelled);
}

TEST(PaperMetric, ColorIsThatOfTheMeanRgb) {
  Options options;
  options.method = Method::kColor;
  RegionGraph graph = step_graph();
  graph.regions[1] = square({0.03, 0, 0}, false, {20, 30, 40}, 27);  // three times the points
  PaperMetric metric = metric_of(graph, View::world(-1, 0, 1), options);
  metric.merge(0, 1);
  const Vec3 mean = 0.25 * Vec3{200 + 60, 10 + 90, 10 + 120};
  EXPECT_DOUBLE_EQ(metric.dissimilarity(0, 2),
                   ciede2000(srgb_to_lab(mean), srgb_to_lab({10, 10, 200})) / kCiede2000Range);
  EXPECT_EQ(metric.points(0), 36U);
}

TEST(PaperMetric, AConvexEdgeHalvesTheGeometricTerm) {
  // The step is concave if it is seen from above and from the left. Seen from behind the wall, its back is convex.
  Options options;
  options.method = Method::kFixedLambda;
  options.lambda = 0;
  RegionGraph graph = step_graph();
  graph.regions[2].centroid.z = -0.02;
  graph.edges = {{1, 2}};
  const View view = View::world(1, 0, 1);
  const double plain = metric_of(graph, view, options).dissimilarity(1, 2);
  options.method = Method::kLambdaConvex;
  const PaperMetric convex = metric_of(graph, view, options);
  const double lambda = convex.lambda();
  const double color = ciede2000(srgb_to_lab({200, 10, 10}), srgb_to_lab({10, 10, 200})) / kCiede2000Range;
  EXPECT_NEAR(convex.dissimilarity(1, 2), lambda * color + (1 - lambda) * plain / 2, 1e-12);
}

}  // namespace
}  // namespace segserve
