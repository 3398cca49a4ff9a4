// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "absl/status/statusor.h"
#include "segserve/v1/cloud.pb.h"
#include "segserve/v1/result.pb.h"
#include "server/frames/frame_settings.hpp"
#include "server/frames/segmentation_backend.hpp"
#include "server/memory/frame_memory.hpp"

namespace segserve::server {

/// Decodes the payload of one frame, segments the cloud and encodes the answer. Stops between these steps and within
/// them when `cancelled` is set, the deadline passes, or the frame has taken its maximum time. `memory` has received
/// the payload; it holds the result in the end. Knows nothing of the transport. Errors of the payload have their reason
/// (see v1.ErrorReason), and so have those of FrameMemory. Libraries may throw: see catch_exceptions.
absl::StatusOr<v1::SegmentationResult> compute_frame(const v1::Cloud& payload, const FrameSettings& settings,
                                                     const std::atomic<bool>& cancelled, SegmentationBackend& backend,
                                                     FrameMemory& memory);

}  // namespace segserve::server
