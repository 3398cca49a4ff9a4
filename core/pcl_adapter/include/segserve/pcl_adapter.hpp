// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "absl/status/statusor.h"
#include "fmt/format.h"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/segment.hpp"

/// segserve for users of PCL. Any point type with x, y, z serves; one with `rgba` (PointXYZRGB,
/// PointXYZRGBA, ..) brings its color, others have none. Positions in meters.
///
/// Do not compile code that includes PCL with -march=native or AVX flags unless your PCL was too:
/// Eigen's alignment differs then, and the program dies in free(). segserve itself needs no flag.
namespace segserve::pcl_adapter {

template <typename PointT>
concept PointWithPosition = requires(const PointT& point) {
  { point.x } -> std::convertible_to<float>;
  { point.y } -> std::convertible_to<float>;
  { point.z } -> std::convertible_to<float>;
};

template <typename PointT>
concept PointWithColor = PointWithPosition<PointT> && requires(const PointT& point) {
  { point.rgba } -> std::convertible_to<std::uint32_t>;
};

/// The view that segserve's PCD reader derives from the same fields: CAMERA if the cloud is organized
/// (height > 1), sensor_origin_ is zero and sensor_orientation_ is the identity; else WORLD with the
/// sensor at sensor_origin_. Nothing applies it unasked: PCL leaves these fields at zero and
/// identity in clouds that were transformed, so pass your own View if you know better.
template <PointWithPosition PointT>
View view_by_pcd_rule(const pcl::PointCloud<PointT>& cloud) {
  const auto& origin = cloud.sensor_origin_;
  const auto& turn = cloud.sensor_orientation_;
  const bool at_zero = origin.x() == 0 && origin.y() == 0 && origin.z() == 0;
  const bool unturned = turn.w() == 1 && turn.x() == 0 && turn.y() == 0 && turn.z() == 0;
  if (cloud.height > 1 && at_zero && unturned) return View::camera();
  return View::world(origin.x(), origin.y(), origin.z());
}

/// The same points in the same order, width and height as the PCL cloud says; points that are not
/// finite stay so. The alpha channel is dropped.
template <PointWithPosition PointT>
Cloud from_pcl(const pcl::PointCloud<PointT>& cloud, const View& view) {
  Cloud result;
  result.resize(cloud.size(), PointWithColor<PointT>);
  result.width = cloud.width;
  result.height = cloud.height;
  result.view = view;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const PointT& point = cloud[i];
    result.x[i] = point.x;
    result.y[i] = point.y;
    result.z[i] = point.z;
    if constexpr (PointWithColor<PointT>) result.rgb[i] = point.rgba & 0x00FFFFFFU;
  }
  return result;
}

/// segserve::segment on a PCL cloud: labels and supervoxels in the order of its points, and the
/// whole merge tree. INVALID_ARGUMENT as there; also if width * height is not the number of points.
template <PointWithPosition PointT>
absl::StatusOr<Segmentation> segment(const pcl::PointCloud<PointT>& cloud, const View& view,
                                     const Options& options = {}, const StopToken& stop = {}) {
  return segserve::segment(from_pcl(cloud, view), options, stop);
}

/// The cloud with a label per point: PointXYZRGBL if its points have color, else PointXYZL. Header,
/// shape and sensor pose are kept. INVALID_ARGUMENT if there is not one label per point.
template <PointWithPosition PointT>
auto with_labels(const pcl::PointCloud<PointT>& cloud, std::span<const std::uint32_t> labels) {
  using Labelled = std::conditional_t<PointWithColor<PointT>, pcl::PointXYZRGBL, pcl::PointXYZL>;
  using Result = absl::StatusOr<pcl::PointCloud<Labelled>>;
  if (labels.size() != cloud.size()) {
    return Result(absl::InvalidArgumentError(
        fmt::format("{} labels for {} points: there must be one per point", labels.size(), cloud.size())));
  }
  pcl::PointCloud<Labelled> result;
  result.header = cloud.header;
  result.sensor_origin_ = cloud.sensor_origin_;
  result.sensor_orientation_ = cloud.sensor_orientation_;
  result.resize(cloud.size());
  result.width = cloud.width;
  result.height = cloud.height;
  result.is_dense = cloud.is_dense;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Labelled& point = result[i];
    point.x = cloud[i].x;
    point.y = cloud[i].y;
    point.z = cloud[i].z;
    if constexpr (PointWithColor<PointT>) point.rgba = cloud[i].rgba;
    point.label = labels[i];
  }
  return Result(std::move(result));
}

}  // namespace segserve::pcl_adapter
