#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/v1/stream.pb.h"
#include "server/frames/frame_settings.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/outbox.hpp"

namespace segserve::server {

/// One frame on its way through a stream.
struct StreamFrame {
  using Clock = std::chrono::steady_clock;
  enum class State { kUploading, kQueued, kRunning, kDone };

  StreamFrame(v1::FrameHeader frame_header, Clock::time_point now) : header(std::move(frame_header)), last_chunk(now) {}

  v1::FrameHeader header;  ///< its cloud gets the payload's bytes once they have come
  FrameSettings settings;
  wire::IncomingBytes payload;
  Clock::time_point last_chunk;

  State state = State::kUploading;
  FrameExecutor::Ticket ticket = 0;  ///< kQueued
  /// Set to end a computation early; `why_stopped` then tells its outcome.
  std::atomic<bool> stopped{false};
  v1::OutcomeKind why_stopped = v1::OUTCOME_KIND_UNSPECIFIED;
  std::optional<FinishedFrame> finished;  ///< kDone, and not yet in the outbox
};

/// Gives the cloud the bytes that came. ABORTED, CHECKSUM if they are not those that were sent.
absl::Status attach_payload(StreamFrame& frame);

/// The outcome of a frame that has no result; OK as its status means none.
FinishedFrame without_result(const StreamFrame& frame, v1::OutcomeKind kind, const absl::Status& status);
/// The outcome of a frame that has one.
FinishedFrame with_result(const StreamFrame& frame, v1::SegmentationResult result);

}  // namespace segserve::server
