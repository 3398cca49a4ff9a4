// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "segserve/client/frame.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/client/stream_options.hpp"

namespace segserve::client {

/// A frame as it was handed over, with nothing left open: what FrameOptions leaves out has the stream's value.
struct FrameRequest {
  Payload payload;
  Options options;
  wire::Outputs outputs;
  std::optional<Prompts> prompts;
  /// Its state is set when the frame is sent if the stream follows objects (FrameQueue::next_to_send).
  std::optional<wire::TrackRequest> tracking = std::nullopt;
  std::string request_id;
  std::string frame_id;
  std::string traceparent;  ///< valid, or empty
  std::optional<std::chrono::system_clock::time_point> stamp;
  Time captured = {};  ///< not later than the hand-over
  std::optional<std::chrono::milliseconds> time_to_live;
  std::int32_t priority = 0;
  std::chrono::milliseconds timeout{};  ///< from when the frame was accepted to its outcome

  /// When the result is of no use any more, if ever.
  std::optional<Time> expires() const;
};

/// Resolves what `frame` leaves out by the options of its stream. `now` is the time of the hand-over.
FrameRequest resolve(Payload payload, FrameOptions frame, const StreamOptions& stream, Time now);

}  // namespace segserve::client
