// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "proto/wire/byte_run.hpp"
#include "segserve/v1/stream.pb.h"
#include "server/access/subject.hpp"
#include "server/frames/frame_settings.hpp"
#include "server/memory/frame_memory.hpp"
#include "server/observe/frame_record.hpp"
#include "server/stream/frame_executor.hpp"
#include "server/stream/outbox.hpp"

namespace segserve::server {

/// One frame on its way through a stream.
struct StreamFrame {
  using Time = FrameSettings::Time;
  enum class State { kUploading, kQueued, kRunning, kDone };

  StreamFrame(v1::FrameHeader frame_header, Time arrival);

  v1::FrameHeader header;       ///< its cloud gets the payload's bytes once they have come
  FrameSettings settings;       ///< set before the payload comes
  wire::IncomingBytes payload;  ///< the bytes that have come so far
  FrameMemory memory;           ///< of the payload and the computation
  QuotaLease quota;             ///< what the frame takes of the limits of its subject
  FrameRecord record;           ///< goes with the outcome; `work` is the worker's while it computes the frame

  State state = State::kUploading;
  FrameExecutor::Ticket ticket = 0;    ///< kQueued
  std::atomic<bool> cancelled{false};  ///< set to end a computation early; `why_cancelled` then tells its outcome
  v1::OutcomeKind why_cancelled = v1::OUTCOME_KIND_UNSPECIFIED;
  std::optional<FinishedFrame> finished;  ///< kDone, and not yet in the outbox
};

using StreamFramePointer = std::shared_ptr<StreamFrame>;

/// Moves the bytes that came into the blocks of the header's cloud. ABORTED, CHECKSUM if they are not the bytes that
/// were sent.
absl::Status attach_payload(StreamFrame& frame);

/// The outcome of a frame that has no result. An OK status is left out of it.
FinishedFrame outcome_without_result(const StreamFrame& frame, v1::OutcomeKind kind, const absl::Status& status);
/// The outcome of a frame that was segmented.
FinishedFrame outcome_with_result(const StreamFrame& frame, v1::SegmentationResult result);

}  // namespace segserve::server
