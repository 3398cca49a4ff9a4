// SPDX-License-Identifier: Apache-2.0
#include "core/codec/pcd/pcd_viewpoint.hpp"

namespace segserve::codec {

bool keeps_viewpoint(const FileContent& content) {
  constexpr double kTolerance = 1e-6;  // of the numbers of a view, which are floats
  if (!content.viewpoint) return false;
  const auto& sensor = content.cloud.view.sensor;
  const Eigen::Vector3d& translation = content.viewpoint->translation;
  return !sensor || (sensor->cast<double>() - translation).norm() <= kTolerance * (1 + translation.norm());
}

}  // namespace segserve::codec
