// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "client/recording/ros/ros_reader.hpp"
#include "client/recording/ros/ros_writer.hpp"

namespace segserve::recording {

/// std_msgs/Header.
struct RosHeader {
  std::uint32_t sequence = 0;  ///< in ROS 1 only
  std::int64_t stamp = 0;      ///< nanoseconds since 1970
  std::string frame_id;
};

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

inline RosHeader read_header(RosReader& reader) {
  RosHeader header;
  const bool is_ros1 = reader.wire() == RosWire::kRos1;
  if (is_ros1) header.sequence = reader.number<std::uint32_t>();
  const auto seconds = reader.number<std::uint32_t>();  // signed in ROS 2
  const std::int64_t signed_seconds = is_ros1 ? std::int64_t{seconds} : static_cast<std::int32_t>(seconds);
  header.stamp = signed_seconds * kNanosecondsPerSecond + reader.number<std::uint32_t>();
  header.frame_id = reader.string();
  return header;
}

inline void write_header(const RosHeader& header, RosWire wire, RosWriter& writer) {
  if (wire == RosWire::kRos1) writer.number(header.sequence);
  std::int64_t seconds = header.stamp / kNanosecondsPerSecond;
  std::int64_t rest = header.stamp % kNanosecondsPerSecond;
  if (rest < 0) {
    rest += kNanosecondsPerSecond;
    --seconds;
  }
  writer.number(static_cast<std::uint32_t>(seconds));
  writer.number(static_cast<std::uint32_t>(rest));
  writer.string(header.frame_id);
}

}  // namespace segserve::recording
