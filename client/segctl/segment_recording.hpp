// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/segctl/segment_arguments.hpp"

namespace segserve::segctl {

/// `segctl segment` on a recording: segments every frame of a topic, and writes the recording with labels (-o), a PCD
/// file a frame (--out-dir) and a JSON object a frame (--json), as asked for. A frame that fails stops no other: it is
/// copied without labels, and told at the end. INVALID_ARGUMENT if every frame that failed was bad input.
absl::Status segment_recording(const SegmentArguments& arguments);

}  // namespace segserve::segctl
