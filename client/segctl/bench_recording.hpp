// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/load_test/load.hpp"
#include "client/segctl/recording_flags.hpp"

namespace segserve::segctl {

/// The clouds of a topic and the times at which they were recorded; no encodings. Frames that cannot be read, have no
/// points, or would take more than 2 GiB of memory together are left out, which a line on standard error tells.
/// INVALID_ARGUMENT unless at least two frames at different times are left; other errors as client::TopicReader.
absl::StatusOr<bench::FrameSource> load_recording(const std::string& path, const RecordingFlags& flags);

/// The clouds of a folder that tells their times (has_capture_times); otherwise as load_recording.
absl::StatusOr<bench::FrameSource> load_sequence(const std::string& folder);

}  // namespace segserve::segctl
