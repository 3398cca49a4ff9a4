// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/labeled_message.hpp"

#include <algorithm>
#include <utility>

#include "client/recording/foxglove/foxglove_messages.hpp"
#include "client/recording/topic/parse_message.hpp"
#include "core/base/status_macros.hpp"
#include "segserve/codec/strided.hpp"

namespace segserve::recording {
namespace {

/// Definitions of the messages, as ros2msg has them.
constexpr const char* kPointCloud2Definition = R"(std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 UINT8=2
uint8 INT16=3
uint8 UINT16=4
uint8 INT32=5
uint8 UINT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
string name
uint32 offset
uint8 datatype
uint32 count
)";

absl::StatusOr<std::string> cloud_of_images(const client::TopicFrame& frame, std::span<const std::uint32_t> labels) {
  const codec::StridedCloud points = codec::encode_strided(frame.content->cloud);
  ASSIGN_OR_RETURN(LabeledPoints labeled, add_labels(points.layout, points.data, labels));
  PointCloud2 cloud;
  cloud.header = {0, frame.stamp.time_since_epoch().count(), frame.frame_id};
  cloud.layout = std::move(labeled.layout);
  cloud.data = labeled.data;
  return encode_point_cloud2(cloud, RosWire::kCdr);
}

}  // namespace

absl::StatusOr<std::string> labeled_message(const RecordedFrame& recorded, std::span<const std::uint32_t> labels) {
  if (is_image(recorded.type.kind)) return cloud_of_images(recorded.frame, labels);
  const MessageEncoding encoding = recorded.type.encoding;
  ASSIGN_OR_RETURN(PointCloud2 cloud, parse_cloud(encoding, recorded.bytes));
  ASSIGN_OR_RETURN(LabeledPoints labeled, add_labels(cloud.layout, cloud.data, labels));
  if (encoding == MessageEncoding::kProtobuf) return with_points(recorded.bytes, labeled.layout, labeled.data);
  cloud.layout = std::move(labeled.layout);
  cloud.data = labeled.data;
  return encode_point_cloud2(cloud, encoding == MessageEncoding::kRos1 ? RosWire::kRos1 : RosWire::kCdr);
}

const Schema& point_cloud2_schema() {
  static const Schema kSchema{"sensor_msgs/msg/PointCloud2", "ros2msg", kPointCloud2Definition};
  return kSchema;
}

}  // namespace segserve::recording
