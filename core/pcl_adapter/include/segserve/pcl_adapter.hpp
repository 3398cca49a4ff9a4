// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pcl/PointIndices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "fmt/format.h"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/rigid_transform.hpp"
#include "segserve/segment.hpp"

/// segserve for users of PCL. Any point type with x, y, z serves; one with `rgba` (PointXYZRGB,
/// PointXYZRGBA, ..) brings its color, others have none. Positions in meters. Normals that points bring are not used,
/// because segserve fits its own. docs/coming_from_pcl.md shows the jobs of PCL's own classes done with it.
///
/// The namespace is not called segserve::pcl, which would hide ::pcl from whoever is using namespace segserve.
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

/// Converts some of the points, in the shape of the whole cloud: all others become points that are not finite, and
/// get label 0. So an organized cloud stays organized. INVALID_ARGUMENT if an index is not that of a point.
template <PointWithPosition PointT>
absl::StatusOr<Cloud> from_pcl(const pcl::PointCloud<PointT>& cloud, const pcl::Indices& indices, const View& view) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  std::vector<bool> is_wanted(cloud.size());
  for (const pcl::index_t index : indices) {
    if (index < 0 || static_cast<std::size_t>(index) >= cloud.size()) {
      return absl::InvalidArgumentError(fmt::format("index {} is not that of one of {} points", index, cloud.size()));
    }
    is_wanted[static_cast<std::size_t>(index)] = true;
  }
  Cloud result = from_pcl(cloud, view);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_wanted[i]) result.x[i] = result.y[i] = result.z[i] = kNaN;
  }
  return result;
}

/// Where the sensor stood, from its own frame to that of the world: sensor_orientation_ and sensor_origin_, as PCL's
/// viewers apply them to a cloud in the frame of its sensor. It is a CameraCloud::pose (segserve/cameras.hpp). The
/// quaternion is normalized; one of length 0 counts as the identity.
template <typename PointT>
RigidTransform sensor_pose(const pcl::PointCloud<PointT>& cloud) {
  RigidTransform pose;
  const Eigen::Quaterniond turn = cloud.sensor_orientation_.template cast<double>();
  if (turn.norm() > 0) pose.rotation = turn.normalized().toRotationMatrix();
  pose.translation = cloud.sensor_origin_.template head<3>().template cast<double>();
  return pose;
}

/// segserve::segment on a PCL cloud: labels and supervoxels in the order of its points, and the
/// whole merge tree. INVALID_ARGUMENT as there; also if width * height is not the number of points.
template <PointWithPosition PointT>
absl::StatusOr<Segmentation> segment(const pcl::PointCloud<PointT>& cloud, const View& view,
                                     const Options& options = {}, const StopToken& stop = {}) {
  return segserve::segment(from_pcl(cloud, view), options, stop);
}

/// Segments some of the points, as those that setIndices gives to PCL's classes. Labels and supervoxels are those
/// of the whole cloud, 0 for points that are not among the indices. INVALID_ARGUMENT also if an index is not that of a
/// point.
template <PointWithPosition PointT>
absl::StatusOr<Segmentation> segment(const pcl::PointCloud<PointT>& cloud, const pcl::Indices& indices,
                                     const View& view, const Options& options = {}, const StopToken& stop = {}) {
  const auto points = from_pcl(cloud, indices, view);
  if (!points.ok()) return points.status();
  return segserve::segment(*points, options, stop);
}

/// The points of each segment, as EuclideanClusterExtraction gives clusters: entry k - 1 has the indices of label k, in
/// ascending order. Segments with fewer than `min_points` or more than `max_points` points are left out. `labels` are
/// those of a Segmentation, a cut, or supervoxels.
inline std::vector<pcl::PointIndices> cluster_indices(
    std::span<const std::uint32_t> labels, std::size_t min_points = 1,
    std::size_t max_points = std::numeric_limits<std::size_t>::max()) {
  std::vector<pcl::PointIndices> clusters;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == 0) continue;
    if (labels[i] > clusters.size()) clusters.resize(labels[i]);
    clusters[labels[i] - 1].indices.push_back(static_cast<pcl::index_t>(i));
  }
  std::erase_if(clusters, [&](const pcl::PointIndices& cluster) {
    return cluster.indices.size() < std::max<std::size_t>(min_points, 1) || cluster.indices.size() > max_points;
  });
  return clusters;
}

/// The unit normal of the supervoxel of each point, turned as the view says; NaN for points without a supervoxel, or if
/// its normals cancel out. The curvature is 0. INVALID_ARGUMENT if the segmentation has no supervoxels or no normals of
/// them, as that of a server.
inline absl::StatusOr<pcl::PointCloud<pcl::Normal>> supervoxel_normals(const Segmentation& segmentation) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3d>& sums = segmentation.supervoxel_normals;
  if (segmentation.supervoxels.empty() || sums.size() != segmentation.tree.leaf_count()) {
    return absl::InvalidArgumentError("the segmentation has no normals of supervoxels: segment in this process");
  }
  pcl::PointCloud<pcl::Normal> normals;
  normals.reserve(segmentation.supervoxels.size());
  for (const std::uint32_t supervoxel : segmentation.supervoxels) {
    const Eigen::Vector3d sum = supervoxel == 0 ? Eigen::Vector3d::Zero() : sums[supervoxel - 1];
    const double length = sum.norm();
    const Eigen::Vector3f unit =
        length > 0 ? Eigen::Vector3f((sum / length).cast<float>()) : Eigen::Vector3f::Constant(kNaN);
    normals.push_back(pcl::Normal(unit.x(), unit.y(), unit.z()));
    normals.is_dense = normals.is_dense && length > 0;
  }
  return normals;
}

/// The cloud with a label per point: PointXYZRGBL if its points have color, else PointXYZL. Header,
/// shape and sensor pose are kept. INVALID_ARGUMENT if there is not one label per point.
template <PointWithPosition PointT>
auto with_labels(const pcl::PointCloud<PointT>& cloud, std::span<const std::uint32_t> labels) {
  using Labeled = std::conditional_t<PointWithColor<PointT>, pcl::PointXYZRGBL, pcl::PointXYZL>;
  using Result = absl::StatusOr<pcl::PointCloud<Labeled>>;
  if (labels.size() != cloud.size()) {
    return Result(absl::InvalidArgumentError(
        fmt::format("{} labels for {} points: there must be one per point", labels.size(), cloud.size())));
  }
  pcl::PointCloud<Labeled> result;
  result.header = cloud.header;
  result.sensor_origin_ = cloud.sensor_origin_;
  result.sensor_orientation_ = cloud.sensor_orientation_;
  result.resize(cloud.size());
  result.width = cloud.width;
  result.height = cloud.height;
  result.is_dense = cloud.is_dense;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Labeled& point = result[i];
    point.x = cloud[i].x;
    point.y = cloud[i].y;
    point.z = cloud[i].z;
    if constexpr (PointWithColor<PointT>) point.rgba = cloud[i].rgba;
    point.label = labels[i];
  }
  return Result(std::move(result));
}

}  // namespace segserve::pcl_adapter
