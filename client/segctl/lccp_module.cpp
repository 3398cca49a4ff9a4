// SPDX-License-Identifier: Apache-2.0
// The module segctl_lccp.so, which peer_method.cpp loads. PCL's libraries take longer to load than most commands take
// in all, so that segctl itself does not link them.
#include "client/segctl/lccp_module.hpp"

void segctl_lccp_partition(const segserve::CloudView& cloud, const segserve::pcl_peer::PeerSettings& settings,
                           absl::StatusOr<segserve::eval::Partition>& result) {
  result = segserve::pcl_peer::partition(cloud, settings);
}
