// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/message_type.hpp"

#include <array>
#include <string>
#include <utility>

namespace segserve::recording {
namespace {

constexpr std::array<std::pair<std::string_view, MessageKind>, 1> kRosKinds{
    {{"sensor_msgs/PointCloud2", MessageKind::kPointCloud2}}};

/// The name of a ROS type as ROS 1 writes it, without "msg/".
std::string ros1_name(std::string name) {
  if (const auto at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

}  // namespace

std::optional<MessageType> message_type(const Channel& channel, const Schema& schema) {
  const bool is_cdr = channel.message_encoding == "cdr";
  if (is_cdr || channel.message_encoding == "ros1") {
    const std::string name = ros1_name(schema.name);
    for (const auto& [ros_name, kind] : kRosKinds) {
      if (name == ros_name) return MessageType{kind, is_cdr ? RosWire::kCdr : RosWire::kRos1};
    }
  }
  return std::nullopt;
}

bool has_frames(MessageKind kind) { return kind == MessageKind::kPointCloud2; }

}  // namespace segserve::recording
