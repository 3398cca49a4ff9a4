// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "client/ros/core/cloud_segmenter.hpp"
#include "client/ros/core/detection.hpp"
#include "segserve/codec/strided.hpp"

// Messages of ROS 1 and ROS 2, whose classes differ while their fields have the same names. These templates fit both,
// and whatever else has such fields.
namespace segserve::ros {

/// A time of ROS 1 (sec, nsec) or ROS 2 (sec, nanosec).
template <typename Time>
Stamp read_stamp(const Time& time) {
  if constexpr (requires { time.nanosec; }) {
    return {time.sec, time.nanosec};
  } else {
    return {time.sec, time.nsec};
  }
}

template <typename Time>
void write_stamp(const Stamp& stamp, Time& time) {
  time.sec = static_cast<decltype(time.sec)>(stamp.seconds);
  if constexpr (requires { time.nanosec; }) {
    time.nanosec = stamp.nanoseconds;
  } else {
    time.nsec = stamp.nanoseconds;
  }
}

/// Sets a text of a message, whose class may be another than std::string.
template <typename Text>
void write_text(std::string_view text, Text& out) {
  out.assign(text.data(), text.size());
}

/// The cloud of a PointCloud2, whose data are not copied. `Pointer` is a shared pointer to the message, which the cloud
/// keeps.
template <typename Pointer>
IncomingCloud incoming_cloud(const Pointer& message) {
  IncomingCloud cloud;
  cloud.frame_id = std::string(std::string_view(message->header.frame_id));
  cloud.stamp = read_stamp(message->header.stamp);
  cloud.layout.width = message->width;
  cloud.layout.height = message->height;
  for (const auto& field : message->fields) {
    cloud.layout.fields.push_back({std::string(std::string_view(field.name)), field.offset,
                                   static_cast<codec::PointDatatype>(field.datatype), field.count});
  }
  cloud.layout.point_step = message->point_step;
  cloud.layout.row_step = message->row_step;
  cloud.layout.is_bigendian = message->is_bigendian != 0;
  cloud.data = std::string_view(reinterpret_cast<const char*>(message->data.data()), message->data.size());
  cloud.is_dense = message->is_dense != 0;
  cloud.owner = std::make_shared<Pointer>(message);
  return cloud;
}

/// The PointCloud2 with labels.
template <typename Message>
Message labeled_message(const SegmentedCloud& cloud) {
  Message message;
  write_text(cloud.frame_id, message.header.frame_id);
  write_stamp(cloud.stamp, message.header.stamp);
  message.width = cloud.layout.width;
  message.height = cloud.layout.height;
  message.fields.resize(cloud.layout.fields.size());
  for (std::size_t i = 0; i < cloud.layout.fields.size(); ++i) {
    const codec::PointField& field = cloud.layout.fields[i];
    write_text(field.name, message.fields[i].name);
    message.fields[i].offset = field.offset;
    message.fields[i].datatype = static_cast<std::uint8_t>(field.datatype);
    message.fields[i].count = field.count;
  }
  message.point_step = cloud.layout.point_step;
  message.row_step = cloud.layout.row_step;
  message.is_bigendian = cloud.layout.is_bigendian;
  message.is_dense = cloud.is_dense;
  message.data.assign(cloud.data.begin(), cloud.data.end());
  return message;
}

/// A marker of visualization_msgs at the box of a detection: its id is that of the detection.
template <typename Marker>
Marker marker_of(const SegmentedCloud& cloud, const Detection& detection, std::int32_t type, const char* name_space) {
  Marker marker;
  write_text(cloud.frame_id, marker.header.frame_id);
  write_stamp(cloud.stamp, marker.header.stamp);
  write_text(name_space, marker.ns);
  marker.id = static_cast<std::int32_t>(detection.id);
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.position.x = detection.center.x();
  marker.pose.position.y = detection.center.y();
  marker.pose.position.z = detection.center.z();
  marker.pose.orientation.x = detection.orientation.x();
  marker.pose.orientation.y = detection.orientation.y();
  marker.pose.orientation.z = detection.orientation.z();
  marker.pose.orientation.w = detection.orientation.w();
  marker.color.r = detection.color[0];
  marker.color.g = detection.color[1];
  marker.color.b = detection.color[2];
  marker.color.a = 1;
  return marker;
}

/// The box of each detection, for programs: `scale` has its full edges along its own axes, meters, and `text` the
/// number of its points. There are no other markers.
template <typename MarkerArray>
MarkerArray detection_message(const SegmentedCloud& cloud) {
  using Marker = typename decltype(MarkerArray::markers)::value_type;
  MarkerArray message;
  for (const Detection& detection : cloud.detections) {
    Marker marker = marker_of<Marker>(cloud, detection, Marker::CUBE, "detections");
    marker.scale.x = detection.size.x();
    marker.scale.y = detection.size.y();
    marker.scale.z = detection.size.z();
    write_text(std::to_string(detection.points), marker.text);
    message.markers.push_back(marker);
  }
  return message;
}

/// Makes the markers for RViz. Those of the cloud before are deleted, and each detection is a translucent box with its
/// id above it.
template <typename MarkerArray>
MarkerArray marker_message(const SegmentedCloud& cloud) {
  using Marker = typename decltype(MarkerArray::markers)::value_type;
  constexpr double kThinnest = 0.001, kLetter = 0.03;  // meters; RViz refuses boxes without an extent
  constexpr float kTranslucent = 0.35F;
  MarkerArray message;
  Marker clear;
  write_text(cloud.frame_id, clear.header.frame_id);
  write_stamp(cloud.stamp, clear.header.stamp);
  clear.action = Marker::DELETEALL;
  message.markers.push_back(clear);
  for (const Detection& detection : cloud.detections) {
    Marker box = marker_of<Marker>(cloud, detection, Marker::CUBE, "boxes");
    box.scale.x = std::max(detection.size.x(), kThinnest);
    box.scale.y = std::max(detection.size.y(), kThinnest);
    box.scale.z = std::max(detection.size.z(), kThinnest);
    box.color.a = kTranslucent;
    message.markers.push_back(box);
    Marker name = marker_of<Marker>(cloud, detection, Marker::TEXT_VIEW_FACING, "ids");
    name.scale.z = kLetter;
    write_text(std::to_string(detection.id), name.text);
    message.markers.push_back(name);
  }
  return message;
}

}  // namespace segserve::ros
