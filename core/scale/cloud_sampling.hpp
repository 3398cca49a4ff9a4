// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/frame_context.hpp"
#include "core/base/stop_check.hpp"

namespace segserve {

/// How a WORLD view samples the scene, estimated from a few compact parts of it.
struct CloudSampling {
  /// The smallest edge of voxels, meters, not below the one that was asked for, at which surfaces hold together: 95 %
  /// of the points lie in voxels with at least five occupied neighbors of 26, and 88 % in voxels without a gap of one
  /// empty layer beside them. Points at 4.5 different places of a voxel, in the mean, are enough as well. 0 if there
  /// are too few points to tell, or if the extent is within the edge that was asked for.
  double connected_edge = 0;
  /// The standard deviation of the points, meters, about the planes that fit them within five such voxels. It is the
  /// 40th percentile, because surfaces that are not flat have larger ones. 0 if there are too few points to tell.
  double noise = 0;
  /// The diagonal of the box that holds 90 % of the points along each axis, meters.
  double extent = 0;
};

/// Looks for voxels of at least finest_edge(extent, edge); `edge` is the usual one, meters, above 0. O(N) for a look at
/// all points, and some milliseconds for the parts. Depends neither on the order of the points nor on the CPU. Leaves
/// off when `check` stops it.
CloudSampling estimate_cloud_sampling(const FrameContext& frame, double edge, StopCheck& check);

/// The edge, meters, that a scene of this extent (CloudSampling) is looked at with where `edge` is the usual one: a
/// hundredth of the extent if that is less, but at least a millimeter.
double finest_edge(double extent, double edge);

}  // namespace segserve
