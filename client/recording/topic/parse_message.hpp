// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "client/recording/images/image_messages.hpp"
#include "client/recording/ros/point_cloud2.hpp"
#include "client/recording/topic/message_type.hpp"

// Reads a message in whichever encoding it has. INVALID_ARGUMENT if it is damaged.
namespace segserve::recording {

absl::StatusOr<PointCloud2> parse_cloud(MessageEncoding encoding, std::string_view bytes);
absl::StatusOr<RawImage> parse_raw_image(MessageEncoding encoding, std::string_view bytes);
absl::StatusOr<CompressedImage> parse_compressed_image(MessageEncoding encoding, std::string_view bytes);
absl::StatusOr<CameraInfo> parse_camera_info(MessageEncoding encoding, std::string_view bytes);

}  // namespace segserve::recording
