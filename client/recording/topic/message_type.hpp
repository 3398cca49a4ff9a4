// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "client/recording/message_source.hpp"
#include "client/recording/ros/ros_reader.hpp"

namespace segserve::recording {

/// The kinds of messages that are read.
enum class MessageKind : std::uint8_t {
  kPointCloud2,  ///< sensor_msgs/PointCloud2
};

struct MessageType {
  MessageKind kind{};
  RosWire wire{};  ///< of ROS messages
};

/// The type of a channel's messages; nothing if they are not read.
std::optional<MessageType> message_type(const Channel& channel, const Schema& schema);

/// Whether frames are made of such messages.
bool has_frames(MessageKind kind);

}  // namespace segserve::recording
