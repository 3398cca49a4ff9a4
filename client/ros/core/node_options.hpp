// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve::ros {

/// The settings of a node of ROS 1 or ROS 2.
struct NodeOptions {
  client::ClientOptions client;
  Options segmentation;
  /// Where the sensor is in the frame of the clouds; unset: the name of the frame and the points tell.
  std::optional<View> view = std::nullopt;
  /// A result is of no use later than this after its cloud came; unset: it always is.
  std::optional<std::chrono::milliseconds> time_to_live = std::chrono::milliseconds(500);
  /// How many clouds are at the server at the same time, 1 to 1024. Of those that wait only the newest is kept.
  std::size_t max_in_flight = 2;
  bool track = false;              ///< whether objects keep their ids from cloud to cloud
  std::uint32_t min_points = 50;   ///< smaller segments are labeled, but are no detections
  bool fallback_to_local = false;  ///< whether clouds are segmented in this process when no server is in reach
};

/// A parameter of the nodes.
struct ParameterInfo {
  std::string name;
  std::string unit;           ///< "" if it has none
  std::string default_value;  ///< "": unset
  std::string description;
};

/// All parameters, those of the segmentation (segserve::option_table) included.
std::vector<ParameterInfo> parameter_table();

/// The options that parameters stand for. Each value is text, whatever its type in ROS: numbers as C writes them,
/// "true" and "false". Parameters that are missing or empty keep their defaults. INVALID_ARGUMENT names every parameter
/// that is unknown or has a wrong value.
absl::StatusOr<NodeOptions> parse_parameters(const std::map<std::string, std::string>& values);

}  // namespace segserve::ros
