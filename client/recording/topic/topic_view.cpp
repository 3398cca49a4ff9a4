// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/topic_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <string_view>

namespace segserve::recording {
namespace {

constexpr std::array<std::string_view, 14> kSensors{"lidar",   "laser",   "velodyne", "ouster", "livox",
                                                    "hesai",   "scan",    "radar",    "sensor", "camera",
                                                    "optical", "rslidar", "depth",    "os_"};
constexpr std::array<std::string_view, 4> kFixedFrames{"map", "odom", "world", "earth"};

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The name without the namespace of a robot: "robot1/map" is "map".
std::string_view last_part(std::string_view name) {
  const auto slash = name.rfind('/');
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

/// Whether the frame belongs to a map, a vehicle or a robot's part, whose axes are not those of a sensor.
bool is_body_frame(std::string_view name) {
  if (std::ranges::find(kFixedFrames, name) != kFixedFrames.end()) return true;
  return name.starts_with("base") || name.ends_with("base") || name.ends_with("link");
}

bool is_sensor_frame(std::string_view name) {
  return std::ranges::any_of(kSensors, [name](std::string_view word) { return name.find(word) != name.npos; });
}

bool is_origin(const Cloud& cloud, std::size_t i) { return cloud.x[i] == 0 && cloud.y[i] == 0 && cloud.z[i] == 0; }

/// Whether all points are in front of a camera, and there are any.
bool is_all_in_front(const Cloud& cloud) {
  std::size_t in_front = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) || is_origin(cloud, i)) continue;
    if (!(cloud.z[i] > 0)) return false;
    ++in_front;
  }
  return in_front > 0;
}

}  // namespace

std::string given_view_rule(const View& view) {
  return view.kind == ViewKind::kCamera ? "CAMERA, as asked for" : "WORLD, as asked for";
}

void choose_view(const std::string& frame_id, bool has_pose, codec::LabeledCloud& content) {
  Cloud& cloud = content.cloud;
  if (has_pose) {
    cloud.view = to_cloud(content.placement, View::world(0, 0, 0));
    content.view_rule = "WORLD with the sensor at (0, 0, 0): the cloud has a pose, which is that of its sensor";
    return;
  }
  const std::string lower = lower_case(frame_id);
  const std::string_view name = last_part(lower);
  const bool is_optical = name.find("optical") != std::string_view::npos;
  const bool is_own_frame = cloud.height > 1 && !is_body_frame(name);
  if ((is_optical || is_own_frame) && is_all_in_front(cloud)) {
    cloud.view = View::camera();
    content.view_rule = fmt::format("CAMERA: every point has z > 0, and {}",
                                    is_optical ? fmt::format("the frame '{}' is that of a camera", frame_id)
                                               : fmt::format("the cloud is organized ({} x {}) in the frame '{}'",
                                                             cloud.width, cloud.height, frame_id));
  } else if (is_sensor_frame(name) || is_own_frame) {
    cloud.view = to_cloud(content.placement, View::world(0, 0, 0));
    content.view_rule = fmt::format("WORLD with the sensor at (0, 0, 0): {}",
                                    is_sensor_frame(name) ? fmt::format("the frame '{}' is that of a sensor", frame_id)
                                                          : "the cloud is organized, as a sensor makes it");
  } else {
    cloud.view = View::world();
    content.view_rule = fmt::format("WORLD without a sensor: the frame '{}' does not tell where it is", frame_id);
  }
}

}  // namespace segserve::recording
