// SPDX-License-Identifier: Apache-2.0
// Bad input is refused with a message that names the fault; odd input gives a sensible result.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "segserve/segment.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string fault(const CloudView& cloud, const Options& options = {}) {
  const absl::Status status = segment(cloud, options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  return std::string(status.message());
}

TEST(BadInput, AnEmptyCloud) { EXPECT_THAT(fault(Cloud{}), HasSubstr("empty")); }

TEST(BadInput, PlanesOfDifferentLength) {
  Cloud cloud = test::random_cloud(10, 1, 2, View::camera());
  cloud.y.pop_back();
  EXPECT_THAT(fault(cloud), HasSubstr("x has 10, y 9, z 10, rgb 10"));
}

TEST(BadInput, AShapeThatIsNotItsSize) {
  Cloud cloud = test::random_cloud(10, 1, 2, View::camera());
  cloud.height = 3;
  EXPECT_THAT(fault(cloud), HasSubstr("width 10 times height 3 is not the number of points, 10"));
  cloud.width = cloud.height = 0x80000000U;  // 2^62, not 0
  EXPECT_THAT(fault(cloud), HasSubstr("is not the number of points"));
}

TEST(BadInput, ASensorThatContradictsTheView) {
  Cloud cloud = test::random_cloud(10, 1, 2, View::camera());
  cloud.view.sensor = {0, 0, 0};
  EXPECT_THAT(fault(cloud), HasSubstr("WORLD only"));
  cloud.view = View::world(0, kNan, 0);
  EXPECT_THAT(fault(cloud), HasSubstr("sensor is not finite"));
}

TEST(BadInput, OptionsOutOfRange) {
  Options options;
  options.threshold = -1;
  options.voxel_resolution = 0;
  EXPECT_THAT(fault(test::random_cloud(10, 1, 2, View::camera()), options),
              AllOf(HasSubstr("threshold"), HasSubstr("voxel_resolution")));
}

TEST(BadInput, CoordinatesBeyondTheGrid) {
  Cloud cloud = test::random_cloud(10, 1, 2, View::world());
  for (std::size_t i = 5; i < 10; ++i) cloud.x[i] = 1e30F;
  EXPECT_THAT(fault(cloud), HasSubstr("point 5 at (1e+30"));
}

TEST(OddInput, SinglePointsBeyondTheGridAreLeftOutAndCounted) {
  Cloud cloud = test::random_cloud(1000, 1, 2, View::world());
  cloud.x[7] = 1e30F;
  const Segmentation s = *segment(cloud, {});
  EXPECT_EQ(s.labels[7], 0U);
  EXPECT_EQ(s.points_beyond_grid, 1U);
  EXPECT_EQ(s.finite_points, 1000U);
  EXPECT_EQ(s.segmented_points, 999U);
}

TEST(OddInput, PointsThatAreFarApartSayWhichResolutionFits) {
  Cloud cloud = test::unorganized(View::world());
  for (int i = 0; i < 30; ++i) {
    for (int k = 0; k < 30; ++k) test::add(cloud, 0.1F * static_cast<float>(i), 0.1F * static_cast<float>(k), 0.01F, 0);
  }
  const Segmentation scattered = *segment(cloud, {.voxel_resolution = 0.0075});
  ASSERT_TRUE(scattered.fitting_resolution);
  EXPECT_GT(*scattered.fitting_resolution, 0.1);
  EXPECT_LT(*scattered.fitting_resolution, 0.5);
  Options fitting;
  fitting.voxel_resolution = *scattered.fitting_resolution;
  fitting.seed_resolution = 1.0;
  EXPECT_FALSE(segment(cloud, fitting)->fitting_resolution);
  EXPECT_FALSE(segment(cloud, {})->fitting_resolution) << "the cloud chooses voxels that fit";
}

TEST(OddInput, WithoutAnyFinitePointAllLabelsAreZero) {
  Cloud cloud = test::unorganized(View::camera());
  for (int i = 0; i < 9; ++i) test::add(cloud, kNan, kNan, kNan, 0);
  for (const bool by_regions : {false, true}) {
    Options options;
    if (by_regions) options.regions = 3;
    const Segmentation s = *segment(cloud, options);
    EXPECT_THAT(s.labels, Each(0U));
    EXPECT_EQ(s.segments, 0U);
    EXPECT_EQ(s.tree.leaf_count(), 0U);
    EXPECT_EQ(s.finite_points, 0U);
  }
}

TEST(OddInput, OnePointIsOneSegment) {
  Cloud cloud = test::unorganized(View::camera());
  test::add(cloud, 0, 0, 1, 0xff0000);
  const Segmentation s = *segment(cloud, {});
  EXPECT_EQ(s.labels, std::vector<std::uint32_t>{1});
  EXPECT_EQ(s.tree.leaf_count(), 1U);
  EXPECT_EQ(s.tree.row_count(), 0U);
}

TEST(OddInput, EqualPointsAreOneSegment) {
  Cloud cloud = test::unorganized(View::world());
  for (int i = 0; i < 1000; ++i) test::add(cloud, 1, 2, 3, 0xffffff);
  const Segmentation s = *segment(cloud, {});
  EXPECT_THAT(s.labels, Each(1U));
  EXPECT_EQ(s.tree.leaf_points, std::vector<std::uint32_t>{1000});
}

/// Segments the cloud, and expects that every point has a label and that the tree is valid.
Segmentation sensible(const CloudView& cloud, Method method) {
  Options options;
  options.method = method;
  Segmentation s = *segment(cloud, options);
  EXPECT_TRUE(check(s.tree).ok()) << check(s.tree) << " by " << name(method);
  EXPECT_THAT(s.labels, Each(testing::Gt(0U)));
  return s;
}

TEST(OddInput, AFlatCloudOfOneColorIsOneSegment) {
  for (const View& view : {View::world(), View::world(0, 0, 1), View::camera()}) {
    Cloud cloud = test::unorganized(view);
    test::add_patch(cloud, -0.3F, -0.3F, 1, 0.6F, 0.005F, 0x808080);
    for (const Method method : all_methods()) {
      if (method == Method::kEqualization || method == Method::kEqualizationConvex) continue;  // They rank weights.
      EXPECT_EQ(sensible(cloud, method).segments, 1U) << name(method);
    }
    sensible(cloud, Method::kEqualization);
    sensible(cloud, Method::kEqualizationConvex);
  }
}

TEST(OddInput, AHundredComponentsAreAHundredSegments) {
  Cloud cloud = test::unorganized();
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      test::add_patch(cloud, 0.5F * static_cast<float>(i), 0.5F * static_cast<float>(j), 0, 0.1F, 0.005F, 0x336699);
    }
  }
  const Segmentation s = sensible(cloud, Method::kLambdaConvex);
  EXPECT_EQ(s.segments, 100U);
  EXPECT_EQ(std::ranges::count(s.tree.kind, MergeKind::kJoined), 99);
}

TEST(OddInput, ACloudWithoutColorIsSegmentedByItsGeometry) {
  Cloud cloud = test::unorganized(View::world(1, 1, 3));
  test::add_patch(cloud, 0, 0, 0, 0.5F, 0.005F, 0);
  test::add_patch(cloud, 2, 2, 1, 0.5F, 0.005F, 0);
  cloud.rgb.clear();
  EXPECT_EQ(sensible(cloud, Method::kLambdaConvex).segments, 2U);
  EXPECT_EQ(sensible(cloud, Method::kColor).segments, 2U);
}

TEST(OddInput, WithoutColorAdaptiveLambdaFallsBackToGeometry) {
  Cloud cloud = test::unorganized(View::world(1, -3, 3));
  test::add_patch(cloud, 0, 0, 0, 0.5F, 0.005F, 0);  // a floor; the wall at its end follows
  for (float x = 0; x < 0.5F; x += 0.005F) {
    for (float z = 0; z < 0.5F; z += 0.005F) test::add(cloud, x, 0.5F, z, 0);
  }
  cloud.rgb.clear();
  const Segmentation geometry = sensible(cloud, Method::kGeometry);
  const Segmentation lambda = sensible(cloud, Method::kLambda);
  EXPECT_EQ(lambda.lambda, 0);
  EXPECT_TRUE(lambda.tree == geometry.tree);
  EXPECT_EQ(cut_to_regions(lambda.tree, 2)->segments, 2U);
}

TEST(OddInput, ColorSegmentsWhatGeometryCannot) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0, 0.4F, 0.005F, 0xff0000);
  test::add_patch(cloud, 0.4F, 0, 0, 0.4F, 0.005F, 0x0000ff);
  const Segmentation s = sensible(cloud, Method::kColor);
  EXPECT_EQ(s.segments, 2U);
  EXPECT_NE(s.labels.front(), s.labels.back());
  EXPECT_EQ(sensible(cloud, Method::kGeometry).segments, 1U);
}

TEST(MinSegmentPoints, LeavesNoSmallerSegmentThatTouchesAnother) {
  Cloud cloud = test::unorganized();
  test::add_patch(cloud, 0, 0, 0, 0.4F, 0.005F, 0xff0000);
  test::add_patch(cloud, 0.4F, 0, 0, 0.1F, 0.005F, 0x0000ff);  // 400 points beside the first, in another color
  test::add_patch(cloud, 2, 2, 0, 0.1F, 0.005F, 0x00ff00);     // 400 points that touch no other
  Options options;
  options.method = Method::kColor;
  EXPECT_EQ(segment(cloud, options)->segments, 3U);
  options.min_segment_points = 1000;
  const Segmentation s = *segment(cloud, options);
  EXPECT_EQ(s.segments, 2U);
  EXPECT_EQ(*label_points(s.supervoxels, *cut_at_threshold(s.tree, *s.threshold)), s.labels);
}

TEST(Stopping, IsHeardBeforeAndDuringTheWork) {
  const Cloud cloud = test::random_cloud(200000, 1, 2, View::camera());
  std::atomic<bool> cancelled = true;
  EXPECT_EQ(segment(cloud, {}, StopToken(&cancelled)).status().code(), absl::StatusCode::kCancelled);
  const StopToken late(nullptr, StopToken::Clock::now());
  EXPECT_EQ(segment(cloud, {}, late).status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST(Stopping, LeavesTheSegmenterUsable) {
  const Cloud cloud = test::random_cloud(20000, 0.5F, 1, View::camera());
  Segmenter segmenter;
  const Segmentation before = *segmenter.segment(cloud, {});
  const StopToken soon(nullptr, StopToken::Clock::now() + std::chrono::milliseconds(2));
  (void)segmenter.segment(cloud, {}, soon);
  const Segmentation after = *segmenter.segment(cloud, {});
  EXPECT_EQ(before.labels, after.labels);
}

}  // namespace
}  // namespace segserve
