// SPDX-License-Identifier: Apache-2.0
#include "segserve/pcl_adapter.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "core/lab/synth/scene.hpp"

namespace segserve::pcl_adapter {
namespace {

using testing::HasSubstr;

template <typename PointT>
pcl::PointCloud<PointT> to_pcl(const Cloud& cloud) {
  pcl::PointCloud<PointT> result(cloud.width, cloud.height);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    result[i].x = cloud.x[i];
    result[i].y = cloud.y[i];
    result[i].z = cloud.z[i];
    if constexpr (PointWithColor<PointT>) result[i].rgba = 0xFF000000U | cloud.rgb[i];
  }
  result.is_dense = false;
  return result;
}

Cloud scene() {
  auto scene = synth::make_tabletop({.seed = 3, .width = 160, .height = 120});
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene->cloud;
}

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

template <typename PointT>
class ColoredPointTest : public testing::Test {};
using ColoredPoints = testing::Types<pcl::PointXYZRGB, pcl::PointXYZRGBA, pcl::PointXYZRGBNormal>;
TYPED_TEST_SUITE(ColoredPointTest, ColoredPoints);

TYPED_TEST(ColoredPointTest, KeepsPointsColorsOrderAndShape) {
  const Cloud expected = scene();
  const Cloud cloud = from_pcl(to_pcl<TypeParam>(expected), View::camera());
  EXPECT_EQ(cloud.width, 160U);
  EXPECT_EQ(cloud.height, 120U);
  EXPECT_EQ(cloud.view, View::camera());
  EXPECT_EQ(cloud.rgb, expected.rgb);  // alpha is gone
  ASSERT_EQ(cloud.size(), expected.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_TRUE(same(cloud.x[i], expected.x[i]) && same(cloud.y[i], expected.y[i]) && same(cloud.z[i], expected.z[i]));
  }
}

TYPED_TEST(ColoredPointTest, SegmentsAsCoreDoes) {
  const Cloud cloud = scene();
  const auto expected = segserve::segment(cloud, {});
  const auto result = segment(to_pcl<TypeParam>(cloud), View::camera());
  ASSERT_TRUE(expected.ok()) << expected.status();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_GT(result->segments, 1U);
  EXPECT_EQ(result->labels, expected->labels);
  EXPECT_EQ(result->supervoxels, expected->supervoxels);
  EXPECT_EQ(result->tree, expected->tree);
}

TEST(FromPclTest, PointsWithoutColorGiveACloudWithoutColor) {
  const Cloud cloud = from_pcl(to_pcl<pcl::PointXYZ>(scene()), View::world());
  EXPECT_FALSE(cloud.has_color());
  EXPECT_EQ(cloud.view, View::world());
  EXPECT_EQ(cloud.size(), 160U * 120U);
}

TEST(SegmentTest, PointsWithoutColorAreSegmented) {
  const auto result = segment(to_pcl<pcl::PointXYZ>(scene()), View::camera());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_GE(result->segments, 1U);
}

TEST(SegmentTest, AShapeThatDoesNotFitIsRefused) {
  pcl::PointCloud<pcl::PointXYZRGB> cloud = to_pcl<pcl::PointXYZRGB>(scene());
  cloud.points.pop_back();  // behind PCL's back: width and height stay
  const auto result = segment(cloud, View::camera());
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(ViewByPcdRuleTest, OrganizedAndUnmovedIsACamera) {
  pcl::PointCloud<pcl::PointXYZRGB> cloud(4, 3);
  EXPECT_EQ(view_by_pcd_rule(cloud), View::camera());
}

TEST(ViewByPcdRuleTest, EverythingElseIsAWorldWithTheSensorAtItsOrigin) {
  pcl::PointCloud<pcl::PointXYZRGB> unorganized(12, 1);
  EXPECT_EQ(view_by_pcd_rule(unorganized), View::world(0, 0, 0));

  pcl::PointCloud<pcl::PointXYZRGB> moved(4, 3);
  moved.sensor_origin_ = Eigen::Vector4f(1, 2, 3, 0);
  EXPECT_EQ(view_by_pcd_rule(moved), View::world(1, 2, 3));

  pcl::PointCloud<pcl::PointXYZRGB> turned(4, 3);
  turned.sensor_orientation_ = Eigen::Quaternionf(0, 1, 0, 0);
  EXPECT_EQ(view_by_pcd_rule(turned), View::world(0, 0, 0));
}

TEST(WithLabelsTest, ColoredPointsGetLabelsAndKeepTheRest) {
  pcl::PointCloud<pcl::PointXYZRGBA> cloud(2, 2);
  for (std::uint32_t i = 0; i < 4; ++i) {
    cloud[i].x = static_cast<float>(i);
    cloud[i].rgba = 0x80102030U + i;
  }
  cloud.sensor_origin_ = Eigen::Vector4f(1, 2, 3, 0);
  cloud.header.frame_id = "kitchen";
  cloud.is_dense = false;
  const std::vector<std::uint32_t> labels{5, 0, 7, 70000};
  const absl::StatusOr<pcl::PointCloud<pcl::PointXYZRGBL>> result = with_labels(cloud, labels);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->width, 2U);
  EXPECT_EQ(result->height, 2U);
  EXPECT_FALSE(result->is_dense);
  EXPECT_EQ(result->header.frame_id, "kitchen");
  EXPECT_EQ(result->sensor_origin_, cloud.sensor_origin_);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ((*result)[i].x, static_cast<float>(i));
    EXPECT_EQ((*result)[i].rgba, 0x80102030U + i);
    EXPECT_EQ((*result)[i].label, labels[i]);
  }
}

TEST(WithLabelsTest, PointsWithoutColorBecomePointXYZL) {
  pcl::PointCloud<pcl::PointXYZ> cloud(1, 1);
  const std::vector<std::uint32_t> labels{3};
  const absl::StatusOr<pcl::PointCloud<pcl::PointXYZL>> result = with_labels(cloud, labels);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ((*result)[0].label, 3U);
}

TEST(WithLabelsTest, TheNumberOfLabelsMustFit) {
  pcl::PointCloud<pcl::PointXYZ> cloud(3, 1);
  const std::vector<std::uint32_t> labels{1, 2};
  const auto result = with_labels(cloud, labels);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("2 labels for 3 points"));
}

}  // namespace
}  // namespace segserve::pcl_adapter
