// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/types.h>

#include "absl/status/statusor.h"
#include "segserve/client/client.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/pcl_adapter.hpp"

/// Clouds of PCL through a server. The target segserve::pcl_client has this header, so that segserve::pcl does without
/// gRPC.
namespace segserve::pcl_adapter {

/// client.segment on a PCL cloud (see from_pcl): labels, supervoxels and merge tree are those of `segment` in this
/// process, bit for bit. Result::segmentation has no normals of supervoxels. Errors are those of Client::segment.
template <PointWithPosition PointT>
absl::StatusOr<client::Result> segment(const client::Client& client, const pcl::PointCloud<PointT>& cloud,
                                       const View& view, const Options& options = {},
                                       const client::CallOptions& call = {}) {
  return client.segment(from_pcl(cloud, view), options, call);
}

/// Segments some of the points. All points are sent, and those that are not among the indices are sent as NaN.
/// INVALID_ARGUMENT also if an index is not that of a point.
template <PointWithPosition PointT>
absl::StatusOr<client::Result> segment(const client::Client& client, const pcl::PointCloud<PointT>& cloud,
                                       const pcl::Indices& indices, const View& view, const Options& options = {},
                                       const client::CallOptions& call = {}) {
  const auto points = from_pcl(cloud, indices, view);
  if (!points.ok()) return points.status();
  return client.segment(*points, options, call);
}

}  // namespace segserve::pcl_adapter
