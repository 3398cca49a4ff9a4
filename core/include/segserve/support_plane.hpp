// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace segserve {

/// The plane of points p with normal . p = offset, in the frame of the cloud, meters.
struct SupportPlane {
  /// Unit vector on the side of the objects: towards the camera, in a WORLD view up (+z). Zero if no plane was found.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset = 0;       ///< meters
  std::size_t points = 0;  ///< how many points belong to the plane; 0 if no plane was found
  bool operator==(const SupportPlane&) const = default;
};

}  // namespace segserve
