// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::picture {

/// A pinhole camera: its position and its axes in the frame of the cloud.
struct Pinhole {
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  Eigen::Vector3d forward = Eigen::Vector3d::UnitZ();
};

/// A range of values without outliers at its ends.
struct Range {
  double low = 0.0;
  double high = 0.0;
  double middle() const { return 0.5 * (low + high); }
  double size() const { return high - low; }
};

/// The range of all but one value in a thousand at each end.
Range robust_range(std::vector<double> values);

/// From where these points of a cloud are seen. From `view_from`, in the frame of the cloud, the camera looks at the
/// middle of the cloud. Otherwise a CAMERA cloud is seen as its camera saw it, and a WORLD cloud from its sensor if
/// that sees nearly all of it at once. A cloud around its sensor, or without one, is seen obliquely from above (+z is
/// up), from the side of the sensor.
Pinhole choose_viewpoint(const CloudView& cloud, const std::vector<std::uint32_t>& points,
                         const std::optional<Eigen::Vector3f>& view_from);

}  // namespace segserve::picture
