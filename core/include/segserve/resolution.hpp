// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace segserve {

/// Why voxels are as large as they are.
enum class ResolutionReason : std::uint8_t {
  kGiven,    ///< "given": the options, or the defaults of a method of the paper, fix it
  kDense,    ///< "dense": the points allow the finest voxels that are taken by themselves
  kSpacing,  ///< "spacing": the points are so far apart that finer voxels would tear surfaces
  kNoise,    ///< "noise": finer voxels would show the noise of the sensor
  kExtent,   ///< "extent": the scene is so small that the usual voxels would be too coarse
  kSweep,    ///< "sweep": voxels are as fine as the rays of a spinning LiDAR, and grow with the range
};

/// The name of a reason, as in results.
std::string_view name(ResolutionReason reason);
/// The reason with this name; nullopt if there is none.
std::optional<ResolutionReason> resolution_reason(std::string_view name);

/// The resolution of a segmentation.
struct Resolution {
  double voxel = 0;  ///< edge of a voxel, meters; in a CAMERA view, and for the reason kSweep, at 1 m distance
  /// Distance between the seeds of supervoxels, meters. With the border method in a CAMERA view, and for the reason
  /// kSweep, it is the distance at 1 m, too.
  double seed = 0;
  ResolutionReason reason = ResolutionReason::kGiven;  ///< of the voxels
  /// CAMERA view: the depth, meters, from which the noise of the sensor, as estimated from the cloud, exceeds the edge
  /// of a voxel. Unset if no noise is known.
  std::optional<double> noise_depth;
};

}  // namespace segserve
