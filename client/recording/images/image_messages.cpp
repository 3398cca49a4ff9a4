// SPDX-License-Identifier: Apache-2.0
#include "client/recording/images/image_messages.hpp"

#include <fmt/format.h>

namespace segserve::recording {
namespace {

absl::Status too_short(std::string_view bytes, std::string_view type) {
  return absl::InvalidArgumentError(
      fmt::format("the {} bytes of the message are no {}: they are too few for what they claim", bytes.size(), type));
}

}  // namespace

absl::StatusOr<RawImage> parse_raw_image(std::string_view bytes, RosWire wire) {
  RosReader reader(bytes, wire);
  RawImage image;
  image.header = read_header(reader);
  image.height = reader.number<std::uint32_t>();
  image.width = reader.number<std::uint32_t>();
  image.encoding = reader.string();
  image.is_bigendian = reader.number<std::uint8_t>() != 0;
  image.step = reader.number<std::uint32_t>();
  image.data = reader.octets();
  if (!reader.ok()) return too_short(bytes, "Image");
  return image;
}

absl::StatusOr<CompressedImage> parse_compressed_image(std::string_view bytes, RosWire wire) {
  RosReader reader(bytes, wire);
  CompressedImage image;
  image.header = read_header(reader);
  image.format = reader.string();
  image.data = reader.octets();
  if (!reader.ok()) return too_short(bytes, "CompressedImage");
  return image;
}

absl::StatusOr<CameraInfo> parse_camera_info(std::string_view bytes, RosWire wire) {
  RosReader reader(bytes, wire);
  CameraInfo info;
  read_header(reader);
  info.height = reader.number<std::uint32_t>();
  info.width = reader.number<std::uint32_t>();
  reader.string();  // the name of the distortion model
  const std::uint32_t count = reader.count(sizeof(double));
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) info.distortion.push_back(reader.number<double>());
  for (double& value : info.k) value = reader.number<double>();
  for (int i = 0; i < 9; ++i) reader.number<double>();  // the rotation of the rectified image
  for (double& value : info.p) value = reader.number<double>();
  if (!reader.ok()) return too_short(bytes, "CameraInfo");
  return info;
}

}  // namespace segserve::recording
