// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/stability.hpp"
#include "segserve/stop_token.hpp"

namespace segserve {

/// A box in any position, in the frame of the cloud, meters: the points center + axes * (a, b, c) with |a|, |b| and |c|
/// at most half_extents.x(), .y() and .z().
struct OrientedBox {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();      ///< the columns are unit vectors, right-handed: a rotation
  Eigen::Vector3d half_extents = Eigen::Vector3d::Zero();  ///< 0 along an axis on which the points do not differ
  bool operator==(const OrientedBox&) const = default;
};

/// Describes one segment, in the frame of the cloud.
struct SegmentStatistics {
  std::uint32_t points = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< mean of the points, meters
  /// The smallest box that holds every point and has the principal axes of the points (the eigenvectors of their
  /// covariance), the axis of the greatest variance first. Boxes with other axes may be smaller.
  OrientedBox box;
  std::optional<Eigen::Vector3d> color;  ///< mean of (R, G, B), sRGB, 0..255 each; unset if the cloud has no color
  /// Direction of the sum of the unit normals of the segment's voxels; a unit vector. It is a mean over the surface,
  /// however densely each part of it was sampled. Unset if the voxels' normals are not known, or if they cancel out.
  std::optional<Eigen::Vector3d> normal;
  /// The thresholds at which the merge tree has the segment, and so its stability. Unset if the tree is not known.
  std::optional<ThresholdRange> thresholds;
  bool operator==(const SegmentStatistics&) const = default;
};

/// The most segments of a result that are described, the largest ones. It bounds time and memory; only results of
/// thousands of fragments reach it.
inline constexpr std::uint32_t kMostDescribedSegments = 10'000;

/// Statistics of segments 1 .. `segments` of a cloud of N points; entry k - 1 describes segment k. `labels` (N) are as
/// in Segmentation::labels; labels above `segments` are ignored. Passes over the points three times. The bytes of the
/// result depend on neither the order of the points, the number of threads nor the CPU. Normals and thresholds are not
/// set: see set_normals and `describe`. A segment without points has a box of no extent at the origin.
///
/// INVALID_ARGUMENT if there are not N labels, more segments than points, or a point of a segment is not finite;
/// CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<std::vector<SegmentStatistics>> describe_segments(const CloudView& cloud,
                                                                 std::span<const std::uint32_t> labels,
                                                                 std::uint32_t segments, unsigned threads = 1,
                                                                 const StopToken& stop = {});

/// Sets the normals from those of the m supervoxels (see Segmentation::supervoxel_normals) that the segments consist
/// of. `segment_of_leaf` (m) is as in Cut; segments without an entry in `statistics` are ignored. The normals are
/// unspecified unless OK is returned. CANCELLED, DEADLINE_EXCEEDED.
absl::Status set_normals(std::span<const Eigen::Vector3d> supervoxel_normals,
                         std::span<const std::uint32_t> segment_of_leaf, std::span<SegmentStatistics> statistics,
                         const StopToken& stop = {});

}  // namespace segserve
