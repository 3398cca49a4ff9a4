// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/message_type.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace segserve::recording {
namespace {

struct KindNames {
  std::string_view ros, foxglove;
  MessageKind kind;
};

constexpr std::array<KindNames, 4> kKinds{
    {{"sensor_msgs/PointCloud2", "foxglove.PointCloud", MessageKind::kPointCloud2},
     {"sensor_msgs/Image", "foxglove.RawImage", MessageKind::kRawImage},
     {"sensor_msgs/CompressedImage", "foxglove.CompressedImage", MessageKind::kCompressedImage},
     {"sensor_msgs/CameraInfo", "foxglove.CameraCalibration", MessageKind::kCameraInfo}}};

/// The name of a ROS type as ROS 1 writes it, without "msg/".
std::string ros1_name(std::string name) {
  if (const auto at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

std::optional<MessageEncoding> encoding_of(std::string_view name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  if (name == "ros1") return MessageEncoding::kRos1;
  if (name == "protobuf") return MessageEncoding::kProtobuf;
  return std::nullopt;
}

}  // namespace

std::optional<MessageType> message_type(const Channel& channel, const Schema& schema) {
  const auto encoding = encoding_of(channel.message_encoding);
  if (!encoding) return std::nullopt;
  const bool is_foxglove = *encoding == MessageEncoding::kProtobuf;
  const auto* found = std::ranges::find(kKinds, is_foxglove ? schema.name : ros1_name(schema.name),
                                        is_foxglove ? &KindNames::foxglove : &KindNames::ros);
  if (found == kKinds.end()) return std::nullopt;
  return MessageType{found->kind, *encoding};
}

bool is_image(MessageKind kind) { return kind == MessageKind::kRawImage || kind == MessageKind::kCompressedImage; }

}  // namespace segserve::recording
