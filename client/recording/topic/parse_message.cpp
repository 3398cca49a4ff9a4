// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/parse_message.hpp"

#include "client/recording/foxglove/foxglove_messages.hpp"

namespace segserve::recording {
namespace {

RosWire wire_of(MessageEncoding encoding) {
  return encoding == MessageEncoding::kRos1 ? RosWire::kRos1 : RosWire::kCdr;
}

}  // namespace

absl::StatusOr<PointCloud2> parse_cloud(MessageEncoding encoding, std::string_view bytes) {
  if (encoding == MessageEncoding::kProtobuf) return parse_foxglove_cloud(bytes);
  return parse_point_cloud2(bytes, wire_of(encoding));
}

absl::StatusOr<RawImage> parse_raw_image(MessageEncoding encoding, std::string_view bytes) {
  if (encoding == MessageEncoding::kProtobuf) return parse_foxglove_raw_image(bytes);
  return parse_raw_image(bytes, wire_of(encoding));
}

absl::StatusOr<CompressedImage> parse_compressed_image(MessageEncoding encoding, std::string_view bytes) {
  if (encoding == MessageEncoding::kProtobuf) return parse_foxglove_compressed_image(bytes);
  return parse_compressed_image(bytes, wire_of(encoding));
}

absl::StatusOr<CameraInfo> parse_camera_info(MessageEncoding encoding, std::string_view bytes) {
  if (encoding == MessageEncoding::kProtobuf) return parse_foxglove_calibration(bytes);
  return parse_camera_info(bytes, wire_of(encoding));
}

}  // namespace segserve::recording
