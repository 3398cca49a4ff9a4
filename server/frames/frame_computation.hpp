#pragma once

#include <chrono>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/v1/cloud.pb.h"
#include "segserve/v1/result.pb.h"
#include "server/frames/segmentation_backend.hpp"

namespace segserve::server {

/// One cloud on its way through the server, whichever RPC brought it. The payload outlives the frame.
struct Frame {
  const v1::Cloud& payload;
  wire::ParsedRequest request;
  std::chrono::steady_clock::time_point arrival;
};

/// Decodes, segments and encodes, and looks for a stop between these steps and within the segmentation. Knows
/// nothing of the transport. Errors of the payload have their reason (see v1.ErrorReason). Libraries may throw:
/// see catch_exceptions.
absl::StatusOr<v1::SegmentationResult> process(const Frame& frame, const codec::DecodeLimits& limits,
                                               SegmentationBackend& segmenter, const StopToken& stop);

}  // namespace segserve::server
