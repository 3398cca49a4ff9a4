// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace segserve {

/// The rigid motion p -> rotation * p + translation; meters.
struct RigidTransform {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< orthonormal, right-handed
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  bool operator==(const RigidTransform&) const = default;
};

}  // namespace segserve
