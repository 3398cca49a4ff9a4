// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "proto/wire/request_message.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/options.hpp"

namespace segserve::server {

/// Everything that the computation of one frame depends on besides its payload. FrameResolver makes it once, when the
/// frame comes, for unary calls and streams alike; decoding, segmentation and encoding read nothing else.
struct FrameSettings {
  using Time = std::chrono::steady_clock::time_point;

  Options options;                             ///< valid; the number of threads is within the server's limit
  wire::Outputs outputs;                       ///< which arrays the answer holds
  std::optional<Prompts> prompts;              ///< places that select, in the coordinates of the payload
  std::optional<wire::TrackRequest> tracking;  ///< valid; set if segments shall have ids over time
  codec::DecodeLimits decode_limits;           ///< of this server
  Time arrival;                              ///< when the call or the header of the frame came; its timings begin here
  std::optional<Time> deadline;              ///< when the computation stops
  std::chrono::milliseconds max_time;        ///< from the beginning of the computation
  std::uint64_t answer_bytes_per_point = 0;  ///< of memory for an answer that takes more than arrays of integers do
  std::uint64_t estimated_points = 0;        ///< for the queue, which must know before the payload is decoded
};

}  // namespace segserve::server
