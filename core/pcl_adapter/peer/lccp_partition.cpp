// SPDX-License-Identifier: Apache-2.0
#include "core/pcl_adapter/peer/lccp_partition.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/exception_status.hpp"
#include "core/base/stopwatch.hpp"

namespace segserve::pcl_peer {
namespace {

/// The number of labels other than 0.
std::size_t count_segments(std::vector<std::uint32_t> labels) {
  std::ranges::sort(labels);
  labels.erase(std::ranges::unique(labels).begin(), labels.end());
  return labels.size() - (!labels.empty() && labels.front() == 0 ? 1 : 0);
}

}  // namespace

absl::StatusOr<eval::Partition> partition(const CloudView& cloud, const PeerSettings& settings) try {
  const PclCloud points(cloud);
  Stopwatch stopwatch;
  const PclSupervoxels supervoxels(points, settings.vccs);
  eval::Partition result;
  result.supervoxels = supervoxels.labels();
  result.labels = settings.only_supervoxels ? result.supervoxels : supervoxels.merge(settings.lccp);
  result.ms = stopwatch.lap();
  result.supervoxel_count = supervoxels.size();
  result.segment_count = count_segments(result.labels);
  return result;
} catch (...) {
  return exception_status("segment by PCL");
}

}  // namespace segserve::pcl_peer
