// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "segserve/options.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "segserve/v1/stream.pb.h"
#include "segserve/wire/outputs.hpp"

namespace segserve::wire {

v1::Compression to_message(Compression compression);
v1::Outputs to_message(const Outputs& outputs);

/// What a request asks for, apart from its payload's bytes.
struct ParsedRequest {
  Options options;  ///< valid
  Outputs outputs;
};

/// INVALID_ARGUMENT, INVALID_FIELD that names every wrong field of the request at once. The payload is
/// not decoded: see decode_cloud.
absl::StatusOr<ParsedRequest> parse_request(const v1::SegmentRequest& request, const Options& defaults);

/// The same for the opening of a stream: what a frame gets that says nothing.
absl::StatusOr<ParsedRequest> parse_open(const v1::StreamOpen& open, const Options& defaults);

/// The same for the header of a frame. What it does not say it has from the stream; options of its own go on top of
/// the server's `defaults`.
absl::StatusOr<ParsedRequest> parse_frame(const v1::FrameHeader& header, const ParsedRequest& stream,
                                          const Options& defaults);

}  // namespace segserve::wire
