// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/recording/ros/ros_header.hpp"
#include "client/recording/ros/ros_reader.hpp"

// The messages of cameras, as ROS has them.
namespace segserve::recording {

/// sensor_msgs/Image: rows of pixels.
struct RawImage {
  RosHeader header;
  std::uint32_t width = 0, height = 0;
  std::string encoding;  ///< such as "rgb8", "16UC1"
  bool is_bigendian = false;
  std::uint32_t step = 0;  ///< bytes from one row to the next
  std::string_view data;   ///< in the message
};

/// sensor_msgs/CompressedImage: the bytes of an image file.
struct CompressedImage {
  RosHeader header;
  std::string format;     ///< such as "jpeg", "rgb8; jpeg compressed bgr8", "16UC1; compressedDepth"
  std::string_view data;  ///< in the message
};

/// sensor_msgs/CameraInfo: the pinhole camera of an image.
struct CameraInfo {
  std::uint32_t width = 0, height = 0;
  std::vector<double> distortion;
  std::array<double, 9> k{};   ///< intrinsics of the image as it was taken, row by row
  std::array<double, 12> p{};  ///< projection of the rectified image, row by row
};

// Each is INVALID_ARGUMENT if the message is shorter than it claims.
absl::StatusOr<RawImage> parse_raw_image(std::string_view bytes, RosWire wire);
absl::StatusOr<CompressedImage> parse_compressed_image(std::string_view bytes, RosWire wire);
absl::StatusOr<CameraInfo> parse_camera_info(std::string_view bytes, RosWire wire);

}  // namespace segserve::recording
