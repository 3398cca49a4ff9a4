// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/stream/frame_request.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/client/stream_options.hpp"
#include "segserve/v1/stream.pb.h"

// The client's types as messages of stream.proto, and back.
namespace segserve::client {

/// The message that opens a stream with these options.
v1::StreamOpen open_message(const StreamOptions& options);

/// The header of a frame on a stream with these options, without what StreamProtocol::begin sets. From `end` on its
/// result is of no use, which the server hears as a time to live.
v1::FrameHeader header_message(const FrameRequest& request, const StreamOptions& stream, Time end, Time now);

/// FAILED for kinds that this version does not know.
OutcomeKind from_message(v1::OutcomeKind kind);

/// Why a server ended a frame in this way. OK for kResult, and for kFailed, where the server says why.
absl::Status status_of(OutcomeKind kind);

}  // namespace segserve::client
