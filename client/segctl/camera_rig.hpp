// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/rigid_transform.hpp"

namespace segserve::segctl {

/// One of the cameras of a file such as cameras.json, which tells where each of them stands:
///
///     {"cameras": [{"file": "camera_0.pcd", "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "translation": [0, 0, 0]}]}
///
/// The rotation, row by row, and the translation, meters, lead from the coordinates of the file, taken in meters, to
/// the frame that all cameras share. The path of the file is relative to the folder of the JSON file.
struct RigCamera {
  std::string file;
  RigidTransform pose;
};

/// The name of the file that `segctl synth --rig` writes.
inline constexpr const char* kRigFile = "cameras.json";

std::string rig_json(std::span<const RigCamera> cameras);

/// The clouds of all cameras as they were read, and as one.
struct RigScene {
  std::vector<std::string> files;              ///< paths, from where the program runs
  std::vector<codec::LabeledCloud> of_camera;  ///< in the frame of each camera
  codec::LabeledCloud merged;                  ///< see merge_cameras
};

/// Reads the file of a rig and the clouds that it names. INVALID_ARGUMENT names the file and the camera that are wrong,
/// and two cameras whose files have one name; NOT_FOUND names a file that is missing.
absl::StatusOr<RigScene> read_rig(const std::string& path, const codec::ReadOptions& options);

}  // namespace segserve::segctl
