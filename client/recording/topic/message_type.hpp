// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "client/recording/message_source.hpp"

namespace segserve::recording {

/// The kinds of messages that are read, by the names of ROS; Foxglove has its own for each.
enum class MessageKind : std::uint8_t {
  kPointCloud2,
  kRawImage,
  kCompressedImage,
  kCameraInfo,
};

enum class MessageEncoding : std::uint8_t { kCdr, kRos1, kProtobuf };

struct MessageType {
  MessageKind kind{};
  MessageEncoding encoding{};
};

/// The type of a channel's messages; nothing if they are not read.
std::optional<MessageType> message_type(const Channel& channel, const Schema& schema);

bool is_image(MessageKind kind);

}  // namespace segserve::recording
