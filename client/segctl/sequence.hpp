// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/codec/file_format.hpp"
#include "segserve/tracking.hpp"

namespace segserve::segctl {

/// A cloud of a sequence.
struct SequenceFrame {
  std::string file;  ///< its name in the folder
  double time = 0;   ///< seconds
  std::optional<RigidTransform> pose;
};

/// A folder of clouds, one after the other in time. Its file sequence.json tells when each of them was captured, and
/// from where:
///
///     {"frames": [{"file": "frame_0000.pcd", "time": 0.0, "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1],
///                  "translation": [0, 0, 0]}]}
///
/// The rotation, row by row, and the translation, meters, lead from the frame of the cloud to one that is fixed to the
/// world; both may be left out. Without that file, the names of the clouds may tell the times (capture_time).
struct Sequence {
  std::vector<SequenceFrame> frames;
  bool has_times = false;  ///< whether the folder tells the times of the frames
};

inline constexpr const char* kSequenceFile = "sequence.json";

std::string sequence_json(const std::vector<SequenceFrame>& frames);

/// The sequence in a folder. If neither sequence.json nor every name tells a time, its clouds come in the order of
/// their names, at `rate` frames a second; those that cannot hold labels are left out if these are needed.
/// INVALID_ARGUMENT if sequence.json is wrong, or there is no cloud; NOT_FOUND if there is no such folder.
absl::StatusOr<Sequence> read_sequence(const std::string& folder, double rate,
                                       codec::ReadableFor use = codec::ReadableFor::kSegmentation);

/// Whether this is a folder that tells the times of its clouds.
bool has_capture_times(const std::string& folder);

}  // namespace segserve::segctl
