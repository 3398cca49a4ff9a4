// SPDX-License-Identifier: Apache-2.0
// Segments a cloud that PCL holds.
#include <cstdio>

#include "segserve/pcl_adapter.hpp"

int main() {
  constexpr int kSide = 100;
  pcl::PointCloud<pcl::PointXYZRGB> wall;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      wall.emplace_back(0.005F * static_cast<float>(column), 0.005F * static_cast<float>(row), 1.0F, 90, 120, 150);
    }
  }
  const auto result = segserve::pcl_adapter::segment(wall, segserve::View::camera());
  if (!result.ok()) {
    std::printf("%s\n", result.status().ToString().c_str());
    return 1;
  }
  std::printf("%zu points, %u segments\n", result->labels.size(), result->segments);
  return result->labels.size() == wall.size() && result->segments == 1 ? 0 : 1;
}
