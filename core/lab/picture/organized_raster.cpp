// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/lab/picture/raster.hpp"

namespace segserve::picture {

Raster rasterize_organized(const CloudView& cloud) {
  Raster raster(cloud.width, cloud.height);
  const auto distance = [&](std::size_t i) {
    if (cloud.view.kind == ViewKind::kCamera) return cloud.z[i];
    if (!cloud.view.sensor) return 1.0F;
    const Eigen::Vector3f& sensor = *cloud.view.sensor;
    return std::hypot(cloud.x[i] - sensor.x(), cloud.y[i] - sensor.y(), cloud.z[i] - sensor.z());
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) continue;
    raster.point[i] = static_cast<std::uint32_t>(i);
    raster.depth[i] = distance(i);
  }
  return raster;
}

}  // namespace segserve::picture
