// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "segserve/wire/result.hpp"

namespace segserve::ros {

/// An object that was found: the box of a segment, in the frame of the cloud.
struct Detection {
  std::uint32_t id = 0;  ///< the label of its points: that of the segment, or the id of its track
  std::uint32_t points = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();                 ///< of the box, meters
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< of the box
  Eigen::Vector3d size = Eigen::Vector3d::Zero();                   ///< full edges of the box, meters
  std::array<float, 3> color{};                                     ///< red, green and blue, 0 to 1
};

/// The labels that are published: ids of tracks if the result has such (0: not followed), or else those of segments.
std::vector<std::uint32_t> published_labels(const wire::Result& result);

/// The segments of a result with statistics that have at least so many points and a label other than 0, largest first.
/// A segment without color gets one by its label, so that neighbors differ.
std::vector<Detection> detections_of(const wire::Result& result, std::uint32_t min_points);

}  // namespace segserve::ros
