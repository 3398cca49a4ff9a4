// SPDX-License-Identifier: Apache-2.0
// Asks a server that is not there to segment a cloud that PCL holds.
#include "segserve/pcl_client.hpp"

#include <cstdio>

int main() {
  const auto client = segserve::client::Client::connect({.address = "127.0.0.1:1"});
  if (!client.ok()) return 1;
  pcl::PointCloud<pcl::PointXYZ> wall;
  wall.emplace_back(0.0F, 0.0F, 1.0F);
  const auto result = segserve::pcl_adapter::segment(*client, wall, segserve::View::camera());
  std::printf("%s\n", result.status().ToString().c_str());
  return absl::IsUnavailable(result.status()) ? 0 : 1;
}
