// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/tracking.hpp"
#include "segserve/wire/outputs.hpp"
#include "segserve/wire/result.hpp"
#include "segserve/wire/tracks.hpp"

// The frames that go into a stream, and the outcomes that come out of it.
namespace segserve::client {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using Result = wire::Result;

/// Belongs to one frame. Everything may be left out.
struct FrameOptions {
  std::optional<Options> options = std::nullopt;        ///< replaces StreamOptions::options as a whole
  std::optional<wire::Outputs> outputs = std::nullopt;  ///< replaces StreamOptions::outputs as a whole
  std::optional<Prompts> prompts = std::nullopt;        ///< see CallOptions::prompts
  std::string request_id = {};                          ///< for logs and tracing; at most 256 bytes; echoed
  std::string frame_id = {};     ///< the caller's name for the coordinate frame; at most 256 bytes; echoed
  std::string traceparent = {};  ///< W3C's Trace Context, version 00, for the server's logs and traces; may be empty
  std::optional<std::chrono::system_clock::time_point> stamp = std::nullopt;  ///< when the cloud was taken; echoed

  /// Leads from the frame of the cloud, in meters, to one that is fixed to the world; for StreamOptions::tracking.
  std::optional<RigidTransform> pose = std::nullopt;
  /// Asks for ids of this frame's segments from a state that the caller hands on, in a stream without
  /// StreamOptions::tracking; `pose` has no meaning then.
  std::optional<wire::TrackRequest> tracking = std::nullopt;

  /// When the cloud was taken, by the steady clock of this machine; unset: when it is handed over.
  std::optional<Time> captured = std::nullopt;
  /// The result is of no use later than this after `captured`: the frame then ends as kExpired.
  std::optional<std::chrono::milliseconds> time_to_live = std::nullopt;
  /// Among frames that wait, those of higher priority go first.
  std::int32_t priority = 0;
  /// The longest time from when send() accepts the frame to its outcome, all repetitions included; unset:
  /// StreamOptions::frame_timeout.
  std::optional<std::chrono::milliseconds> timeout = std::nullopt;
};

/// How a frame ended.
enum class OutcomeKind : std::uint8_t {
  kResult,     ///< it was segmented
  kDropped,    ///< it made way for a newer frame
  kExpired,    ///< its time to live was over, or too little of it was left to compute the frame
  kCancelled,  ///< by cancel(), or because the stream was closed
  kFailed,     ///< because of an error
};

/// "RESULT", "DROPPED", "EXPIRED", "CANCELLED" or "FAILED".
const char* name(OutcomeKind kind);

/// The times and costs of a frame. Times are Time{} if they did not come. Those of an attempt are of the one that was
/// answered, or else of the last.
struct FrameReport {
  Time handed_over = {};             ///< send() accepted the frame
  Time header_sent = {};             ///< in this attempt, the frame's header went to the transport
  Time payload_sent = {};            ///< in this attempt, its last byte did
  Time outcome_begun = {};           ///< the first byte of the answer came
  Time outcome_done = {};            ///< the last byte of the answer came, or the frame ended without one
  std::uint32_t attempts = 0;        ///< how often the frame was sent; 1 if all went well
  std::uint64_t bytes_sent = 0;      ///< by all messages about the frame in this attempt
  std::uint64_t bytes_received = 0;  ///< by all messages of the answer
  double decode_ms = 0;              ///< from the bytes of the answer to the Result, in this process
  std::string address = {};          ///< of the server that answered; empty: none did
  /// A second server got the frame, too, because the first was late (StreamOptions::hedge_after) or silent.
  bool hedged = false;
  bool local = false;  ///< segmented in this process, because no server was in reach
};

/// The end of a frame.
struct Outcome {
  std::uint64_t sequence = 0;  ///< that send() returned
  std::string request_id = {}, frame_id = {};
  std::optional<std::chrono::system_clock::time_point> stamp = std::nullopt;
  OutcomeKind kind = OutcomeKind::kFailed;
  absl::Status status = {};  ///< OK for kResult; else why. wire::details_of gives the details to programs
  std::optional<Result> result = std::nullopt;  ///< set for kResult
  FrameReport report = {};
};

}  // namespace segserve::client
