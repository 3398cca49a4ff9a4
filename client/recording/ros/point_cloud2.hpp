// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/recording/ros/ros_header.hpp"
#include "client/recording/ros/ros_reader.hpp"
#include "segserve/codec/strided.hpp"

namespace segserve::recording {

/// sensor_msgs/PointCloud2.
struct PointCloud2 {
  RosHeader header;
  codec::StridedLayout layout;
  std::string_view data;  ///< in the message
  bool is_dense = false;
  bool has_pose = false;  ///< of Foxglove's messages: the points lie in a frame that is moved against header.frame_id
};

/// Reads a message. INVALID_ARGUMENT if it is shorter than it claims, or has more than 4,096 fields. The layout itself
/// is not checked (codec::check_layout).
absl::StatusOr<PointCloud2> parse_point_cloud2(std::string_view bytes, RosWire wire);

std::string encode_point_cloud2(const PointCloud2& cloud, RosWire wire);

/// A cloud whose points have one field more, and the bytes of its points.
struct LabeledPoints {
  codec::StridedLayout layout;
  std::string data;
};

/// Adds the field `label`, UINT32, behind the other fields of every point. A field `label` that is there is renamed to
/// `input_label`. If there is one of that name, too, as from an earlier run, a label of type UINT32 gets the new
/// values, and another one is renamed to `label_before`. `labels` has an entry a point, and `data` layout.bytes()
/// bytes. INVALID_ARGUMENT if a point or row becomes too large for PointCloud2.
absl::StatusOr<LabeledPoints> add_labels(const codec::StridedLayout& layout, std::string_view data,
                                         std::span<const std::uint32_t> labels);

}  // namespace segserve::recording
