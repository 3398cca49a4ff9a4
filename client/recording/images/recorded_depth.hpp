// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "client/recording/images/image_messages.hpp"
#include "core/codec/rgbd/image_size.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/rgbd.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::recording {

/// Depth along the camera's z axis.
struct DepthImage {
  codec::ImageSize size;
  std::vector<float> meters;  ///< width * height, row by row; NaN: not measured
  std::uint64_t largest = 0;  ///< pixels of 65535, which is no distance
};

/// Decodes 16UC1 and mono16 (millimeters; 0 and 65535: not measured) and 32FC1 (meters), as ROS's REP 118 says.
/// INVALID_ARGUMENT for other encodings, too few bytes and exceeded limits; CANCELLED and DEADLINE_EXCEEDED as `stop`
/// says.
absl::StatusOr<DepthImage> decode_depth(const RawImage& image, const codec::DecodeLimits& limits,
                                        const StopToken& stop);

/// Decodes a PNG of 16 bits, in millimeters, alone or as ROS's compressedDepth has it (12 bytes before it; of 32FC1 it
/// holds inverse depth). INVALID_ARGUMENT for other formats, damage and exceeded limits; `stop` as above.
absl::StatusOr<DepthImage> decode_depth(const CompressedImage& image, const codec::DecodeLimits& limits,
                                        const StopToken& stop);

/// The points of the pixels, by the equations of codec::decode_rgbd, in a CAMERA cloud without color. CANCELLED and
/// DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<Cloud> to_cloud(const DepthImage& depth, const codec::Intrinsics& camera, const StopToken& stop);

}  // namespace segserve::recording
