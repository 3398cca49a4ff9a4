// SPDX-License-Identifier: Apache-2.0
#include "client/ros/core/ros_messages.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "test/client/ros/fake_ros.hpp"

namespace segserve::ros {
namespace {

template <typename Time>
class RosMessages : public testing::Test {};
using Versions = testing::Types<fake::Time1, fake::Time2>;
TYPED_TEST_SUITE(RosMessages, Versions);

template <typename Time>
std::shared_ptr<fake::PointCloud2<Time>> cloud_message() {
  auto message = std::make_shared<fake::PointCloud2<Time>>();
  message->header.frame_id = "camera";
  write_stamp({12, 34}, message->header.stamp);
  message->width = 2;
  message->height = 1;
  message->fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}};
  message->point_step = 12;
  message->row_step = 24;
  message->data.resize(24, 7);
  message->is_dense = 1;
  return message;
}

SegmentedCloud segmented() {
  SegmentedCloud cloud;
  cloud.frame_id = "camera";
  cloud.stamp = {12, 34};
  Detection& detection = cloud.detections.emplace_back();
  detection.id = 5;
  detection.points = 123;
  detection.center = {1, 2, 3};
  detection.size = {0.5, 0.25, 0};
  detection.color = {1, 0.5F, 0};
  return cloud;
}

TYPED_TEST(RosMessages, ACloudComesInWithoutACopyAndIsKept) {
  auto message = cloud_message<TypeParam>();
  const auto* const data = message->data.data();
  IncomingCloud cloud = incoming_cloud(message);
  message.reset();
  EXPECT_EQ(static_cast<const void*>(cloud.data.data()), data);
  EXPECT_EQ(cloud.data, std::string(24, 7));
  EXPECT_EQ(cloud.frame_id, "camera");
  EXPECT_EQ(cloud.stamp, (Stamp{12, 34}));
  EXPECT_EQ(cloud.layout.fields[2].name, "z");
  EXPECT_EQ(cloud.layout.fields[2].offset, 8U);
  EXPECT_EQ(cloud.layout.fields[2].datatype, codec::PointDatatype::kFloat32);
  EXPECT_EQ(cloud.layout.bytes(), 24U);
  EXPECT_TRUE(cloud.is_dense);
}

TYPED_TEST(RosMessages, ACloudGoesOutAsItCameIn) {
  const auto message = cloud_message<TypeParam>();
  const IncomingCloud in = incoming_cloud(message);
  const auto out = labeled_message<fake::PointCloud2<TypeParam>>(
      {in.frame_id, in.stamp, in.layout, std::string(in.data), in.is_dense, {}});
  EXPECT_EQ(out.header.frame_id, "camera");
  EXPECT_EQ(read_stamp(out.header.stamp), (Stamp{12, 34}));
  EXPECT_EQ(out.data, message->data);
  EXPECT_EQ(out.fields.size(), 3U);
  EXPECT_EQ(out.fields[1].datatype, 7);
  EXPECT_EQ(out.width, 2U);
  EXPECT_EQ(out.row_step, 24U);
  EXPECT_EQ(out.is_dense, 1);
}

TYPED_TEST(RosMessages, DetectionsAreBoxesWithFullEdges) {
  const auto message = detection_message<fake::MarkerArray<TypeParam>>(segmented());
  ASSERT_EQ(message.markers.size(), 1U);
  const auto& box = message.markers[0];
  EXPECT_EQ(box.id, 5);
  EXPECT_EQ(box.type, fake::Marker<TypeParam>::CUBE);
  EXPECT_EQ(box.pose.position.z, 3);
  EXPECT_EQ(box.pose.orientation.w, 1);
  EXPECT_EQ(box.scale.x, 0.5);
  EXPECT_EQ(box.scale.z, 0);
  EXPECT_EQ(box.color.g, 0.5F);
  EXPECT_EQ(box.text, "123");
  EXPECT_EQ(read_stamp(box.header.stamp), (Stamp{12, 34}));
}

TYPED_TEST(RosMessages, MarkersReplaceThoseBeforeThem) {
  const auto message = marker_message<fake::MarkerArray<TypeParam>>(segmented());
  ASSERT_EQ(message.markers.size(), 3U);
  EXPECT_EQ(message.markers[0].action, fake::Marker<TypeParam>::DELETEALL);
  EXPECT_EQ(message.markers[1].ns, "boxes");
  EXPECT_GT(message.markers[1].scale.z, 0) << "RViz refuses boxes without an extent";
  EXPECT_LT(message.markers[1].color.a, 1);
  EXPECT_EQ(message.markers[2].type, fake::Marker<TypeParam>::TEXT_VIEW_FACING);
  EXPECT_EQ(message.markers[2].text, "5");
}

}  // namespace
}  // namespace segserve::ros
