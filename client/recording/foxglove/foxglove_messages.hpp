// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/recording/images/image_messages.hpp"
#include "client/recording/ros/point_cloud2.hpp"

// Foxglove's messages in protobuf (https://docs.foxglove.dev/docs/sdk/schemas), read as those of ROS that say the same.
// Each reader is INVALID_ARGUMENT if the message is damaged.
namespace segserve::recording {

/// foxglove.PointCloud: an unorganized cloud. INVALID_ARGUMENT also if the data are no whole points.
absl::StatusOr<PointCloud2> parse_foxglove_cloud(std::string_view bytes);
/// The message with other points: everything but the layout and data is copied. Its fields must have a count of 1.
std::string with_points(std::string_view bytes, const codec::StridedLayout& layout, std::string_view data);

absl::StatusOr<RawImage> parse_foxglove_raw_image(std::string_view bytes);
absl::StatusOr<CompressedImage> parse_foxglove_compressed_image(std::string_view bytes);
/// foxglove.CameraCalibration.
absl::StatusOr<CameraInfo> parse_foxglove_calibration(std::string_view bytes);

}  // namespace segserve::recording
