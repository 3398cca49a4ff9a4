// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/rigid_transform.hpp"

// Several cameras that see one scene at the same time: their clouds become one cloud with one merge tree, in which each
// normal is turned to the camera that saw the surface.
namespace segserve {

/// The cloud of one of several cameras.
struct CameraCloud {
  /// In the frame of the camera, meters: a CAMERA view, or a WORLD view with the position of the sensor.
  CloudView cloud;
  /// From the frame of the cloud to the frame that all cameras share: the extrinsics of the camera. If the support
  /// plane shall be found or objects shall be followed, z must point up in the shared frame.
  RigidTransform pose = {};
};

/// The clouds of all cameras as one, in the frame that they share. The points of the first cloud come first, in their
/// order, then those of the second, and so on. The cloud has one row, the WORLD view, and the cameras in View::cameras.
/// Points at (0, 0, 0) of a CAMERA view, which are pixels without depth, become points that are not finite.
///
/// Coordinates are transformed in double, in one order on every CPU, and rounded to float. INVALID_ARGUMENT, which
/// names the camera by its index: there is no cloud, there are more than kMostCameras, a cloud has the wrong shape
/// (`check_shape`), does not say where its sensor is, is itself of several cameras, has a pose that is not finite or no
/// rotation, or some of the clouds have color and others have none.
absl::StatusOr<Cloud> merge_cameras(std::span<const CameraCloud> cameras);

/// The entries of a list with one for each point of a merged cloud, such as its labels, camera by camera: in the order
/// of the points of each camera. They lie in `values`, which must outlive them. INVALID_ARGUMENT if the view has no
/// cameras, or other numbers of points than there are values.
absl::StatusOr<std::vector<std::span<const std::uint32_t>>> split_by_camera(const View& view,
                                                                            std::span<const std::uint32_t> values);

/// Says what is wrong with a transform, or nothing. It must be finite, and its rotation orthonormal and right-handed,
/// but for the rounding of calibrations that are written with few digits (1e-3).
std::optional<std::string> fault_of_transform(const RigidTransform& transform);

}  // namespace segserve
