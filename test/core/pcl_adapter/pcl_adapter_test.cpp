// SPDX-License-Identifier: Apache-2.0
#include "segserve/pcl_adapter.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

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

TEST(IndicesTest, OnlyTheirPointsAreSegmentedAndTheShapeStays) {
  const pcl::PointCloud<pcl::PointXYZRGB> points = to_pcl<pcl::PointXYZRGB>(scene());
  pcl::Indices indices;
  for (pcl::index_t i = 0; i < static_cast<pcl::index_t>(points.size() / 2); ++i) indices.push_back(i);
  const auto cloud = from_pcl(points, indices, View::camera());
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->width, 160U);
  EXPECT_EQ(cloud->height, 120U);
  EXPECT_TRUE(std::isnan(cloud->x.back()));
  EXPECT_TRUE(same(cloud->x.front(), points.front().x));

  const auto result = segment(points, indices, View::camera());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->labels, segserve::segment(*cloud, {})->labels);
  EXPECT_GT(result->segmented_points, 0U);
  for (std::size_t i = indices.size(); i < points.size(); ++i) ASSERT_EQ(result->labels[i], 0U);
}

TEST(IndicesTest, ThoseOfNoPointAreNamed) {
  const auto points = to_pcl<pcl::PointXYZ>(scene());
  for (const pcl::index_t index : {-1, 160 * 120}) {
    const auto result = segment(points, pcl::Indices{0, index}, View::camera());
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(result.status().message()), HasSubstr("index " + std::to_string(index) + " is not that"));
  }
}

TEST(ClusterIndicesTest, HaveThePointsOfEachLabel) {
  const std::vector<std::uint32_t> labels{2, 0, 1, 1, 3, 1, 2};
  const auto indices_of = [](const std::vector<pcl::PointIndices>& clusters) {
    std::vector<pcl::Indices> indices;
    for (const pcl::PointIndices& cluster : clusters) indices.push_back(cluster.indices);
    return indices;
  };
  EXPECT_THAT(indices_of(cluster_indices(labels)),
              testing::ElementsAre(pcl::Indices{2, 3, 5}, pcl::Indices{0, 6}, pcl::Indices{4}));
  EXPECT_THAT(indices_of(cluster_indices(labels, 2, 2)), testing::ElementsAre(pcl::Indices{0, 6}));
  EXPECT_TRUE(cluster_indices({}).empty());
}

TEST(SupervoxelNormalsTest, AreUnitVectorsThatFaceTheCamera) {
  const Cloud cloud = scene();
  const auto result = segment(to_pcl<pcl::PointXYZRGB>(cloud), View::camera());
  ASSERT_TRUE(result.ok()) << result.status();
  const auto normals = supervoxel_normals(*result);
  ASSERT_TRUE(normals.ok()) << normals.status();
  ASSERT_EQ(normals->size(), cloud.size());
  std::size_t facing = 0, known = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const pcl::Normal& normal = (*normals)[i];
    ASSERT_TRUE(result->supervoxels[i] != 0 || std::isnan(normal.normal_x));
    if (std::isnan(normal.normal_x)) continue;
    ++known;
    EXPECT_NEAR(normal.getNormalVector3fMap().norm(), 1, 1e-5);
    facing += normal.normal_x * cloud.x[i] + normal.normal_y * cloud.y[i] + normal.normal_z * cloud.z[i] < 0 ? 1 : 0;
  }
  EXPECT_GT(known, cloud.size() / 4);
  EXPECT_GT(facing, known * 95 / 100);
  EXPECT_EQ(supervoxel_normals(Segmentation()).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(SensorPoseTest, IsThatOfTheCloud) {
  pcl::PointCloud<pcl::PointXYZ> cloud(4, 3);
  EXPECT_EQ(sensor_pose(cloud), RigidTransform());
  cloud.sensor_origin_ = Eigen::Vector4f(1, 2, 3, 0);
  cloud.sensor_orientation_ = Eigen::Quaternionf(0, 2, 0, 0);  // half a turn about x, not normalized
  const RigidTransform pose = sensor_pose(cloud);
  EXPECT_EQ(pose.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(pose.rotation.isApprox(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()));
  cloud.sensor_orientation_ = Eigen::Quaternionf(0, 0, 0, 0);
  EXPECT_EQ(sensor_pose(cloud).rotation, Eigen::Matrix3d::Identity());
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
