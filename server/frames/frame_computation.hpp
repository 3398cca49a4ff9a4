// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "absl/status/statusor.h"
#include "proto/wire/cloud_message.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/v1/cloud.pb.h"
#include "segserve/v1/result.pb.h"
#include "segserve/wire/result.hpp"
#include "server/frames/frame_settings.hpp"
#include "server/frames/frame_work.hpp"
#include "server/frames/segmentation_backend.hpp"
#include "server/memory/frame_memory.hpp"

namespace segserve::server {

/// Decodes a payload within the limits, which grow if it turns out to be larger than it seemed.
using DecodePayload =
    std::function<absl::StatusOr<wire::DecodedCloud>(const codec::DecodeLimits& limits, const StopToken& stop)>;
/// Makes the answer of a result, of which it may take parts, and returns the bytes of memory that the answer holds.
using EncodeResult = std::function<absl::StatusOr<std::uint64_t>(wire::Result& result, const CloudView& cloud)>;

/// Does what the next function does, for payloads and answers of any kind.
absl::Status compute_frame(const DecodePayload& decode, const EncodeResult& encode, const FrameSettings& settings,
                           const std::atomic<bool>& cancelled, SegmentationBackend& backend, FrameMemory& memory,
                           FrameWork& work);

/// Decodes the payload of one frame, segments the cloud and encodes the answer. Stops between these steps and within
/// them when `cancelled` is set, the deadline passes, or the frame has taken its maximum time. `memory` has received
/// the payload; it holds the result in the end. `work` gets what is known of the frame so far, however it ends. Knows
/// nothing of the transport. Errors of the payload have their reason
/// (see v1.ErrorReason), and so have those of FrameMemory. Libraries may throw: see catch_exceptions.
absl::StatusOr<v1::SegmentationResult> compute_frame(const v1::Cloud& payload, const FrameSettings& settings,
                                                     const std::atomic<bool>& cancelled, SegmentationBackend& backend,
                                                     FrameMemory& memory, FrameWork& work);

}  // namespace segserve::server
