// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "segserve/v1/stream.pb.h"
#include "segserve/wire/outputs.hpp"
#include "segserve/wire/tracks.hpp"

namespace segserve::wire {

/// The message of a compression.
v1::Compression to_message(Compression compression);

/// The message of the outputs.
v1::Outputs to_message(const Outputs& outputs);

/// The parameters of a request, without its payload.
struct ParsedRequest {
  Options options;                                      ///< valid options
  Outputs outputs;                                      ///< Outputs() if the request does not say which
  std::optional<Prompts> prompts = std::nullopt;        ///< in the coordinates of the payload
  std::optional<TrackRequest> tracking = std::nullopt;  ///< valid; unset for a stream, whose frames have their own
};

/// Reads everything but the payload's bytes, which decode_cloud reads. Options that are unset take their values from
/// `defaults`. INVALID_ARGUMENT, INVALID_FIELD if a field is wrong; the error names every wrong field.
absl::StatusOr<ParsedRequest> parse_request(const v1::SegmentRequest& request, const Options& defaults);

/// Reads the opening of a stream. The result applies to frames that do not say otherwise. Defaults and errors are those
/// of parse_request.
absl::StatusOr<ParsedRequest> parse_open(const v1::StreamOpen& open, const Options& defaults);

/// Reads the header of a frame. If it has options, they replace those of the stream as a whole, and those that are
/// unset take their values from `defaults`. If it has outputs, they replace those of the stream as a whole. Prompts are
/// those of the frame alone. Errors are those of parse_request.
absl::StatusOr<ParsedRequest> parse_frame(const v1::FrameHeader& header, const ParsedRequest& stream,
                                          const Options& defaults);

}  // namespace segserve::wire
