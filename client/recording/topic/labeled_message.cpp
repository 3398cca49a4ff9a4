// SPDX-License-Identifier: Apache-2.0
#include "client/recording/topic/labeled_message.hpp"

#include <utility>

#include "client/recording/ros/point_cloud2.hpp"
#include "core/base/status_macros.hpp"

namespace segserve::recording {

absl::StatusOr<std::string> labeled_message(const RecordedFrame& recorded, std::span<const std::uint32_t> labels) {
  ASSIGN_OR_RETURN(PointCloud2 cloud, parse_point_cloud2(recorded.bytes, recorded.type.wire));
  ASSIGN_OR_RETURN(LabeledPoints labeled, add_labels(cloud.layout, cloud.data, labels));
  cloud.layout = std::move(labeled.layout);
  cloud.data = labeled.data;
  return encode_point_cloud2(cloud, recorded.type.wire);
}

}  // namespace segserve::recording
