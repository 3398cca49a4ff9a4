#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"
#include "segserve/options.hpp"

// What goes into a stream and what comes out of it.
namespace segserve::client {

using Clock = std::chrono::steady_clock;
using Time = Clock::time_point;
using Result = wire::Result;

/// What is said with a frame. Everything may be left out.
struct FrameOptions {
  std::optional<Options> options = std::nullopt;        ///< instead of the stream's, as a whole
  std::optional<wire::Outputs> outputs = std::nullopt;  ///< the same
  std::string request_id = {};                          ///< for logs and tracing; at most 256 bytes; echoed
  std::string frame_id = {};  ///< coordinate frame, by the caller's name; at most 256 bytes; echoed
  std::optional<std::chrono::system_clock::time_point> stamp = std::nullopt;  ///< when it was taken; echoed

  /// When the cloud was taken, by this machine's steady clock; unset: when it is handed over.
  std::optional<Time> captured = std::nullopt;
  /// The result is of no use later than this after `captured`: the frame then ends as EXPIRED.
  std::optional<std::chrono::milliseconds> time_to_live = std::nullopt;
  /// Among frames that wait, those of higher priority go first.
  std::int32_t priority = 0;
  /// From hand-over to outcome, all repetitions included; unset: StreamOptions::frame_timeout.
  std::optional<std::chrono::milliseconds> timeout = std::nullopt;
};

/// How a frame ended.
enum class OutcomeKind : std::uint8_t {
  kResult,     ///< segmented
  kDropped,    ///< made way for a newer one
  kExpired,    ///< its time to live was over
  kCancelled,  ///< by cancel(), or because the stream was closed
  kFailed,     ///< by an error
};

/// "RESULT", "DROPPED", ..
const char* name(OutcomeKind kind);

/// When what happened to a frame, and what it cost. Times that did not come are those of the clock's epoch.
struct FrameReport {
  Time handed_over = {};         ///< send() took it
  Time header_sent = {};         ///< last attempt: its header went to the transport
  Time payload_sent = {};        ///< its last chunk did
  Time outcome_begun = {};       ///< first byte of the answer
  Time outcome_done = {};        ///< last byte of the answer
  std::uint32_t attempts = 0;    ///< how often it was sent; 1 if all went well
  std::uint64_t bytes_sent = 0;  ///< messages about this frame, last attempt
  std::uint64_t bytes_received = 0;
  double decode_ms = 0;      ///< answer's bytes to Result, in this process
  std::string address = {};  ///< who answered; empty: nobody
  bool local = false;        ///< segmented in this process, because no server was in reach
};

/// What became of a frame.
struct Outcome {
  std::uint64_t sequence = 0;
  std::string request_id = {}, frame_id = {};
  std::optional<std::chrono::system_clock::time_point> stamp = std::nullopt;
  OutcomeKind kind = OutcomeKind::kFailed;
  absl::Status status = {};  ///< OK for kResult; else why. wire::details_of gives the details to programs
  std::optional<Result> result = std::nullopt;  ///< kResult
  FrameReport report = {};
};

}  // namespace segserve::client
