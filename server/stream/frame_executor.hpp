// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include "absl/status/statusor.h"
#include "server/frames/segmentation_backend.hpp"

namespace segserve::server {

/// The facts about a frame that a worker needs.
struct FrameJob {
  std::int32_t priority = 0;
  std::uint64_t points = 0;  ///< an estimate, because the payload is not decoded yet
  std::uint64_t bytes = 0;   ///< of the payload
  /// The frame is queued even if the queue is full. The stream's credit bounds such frames before they come.
  bool may_exceed_queue = false;
  /// Must not throw.
  std::function<void(SegmentationBackend&)> run;
};

/// Computes the frames of a stream: the worker pool, or a test. No function waits for a job, and none runs a job before
/// it returns.
class FrameExecutor {
 public:
  using Ticket = std::uint64_t;

  virtual ~FrameExecutor() = default;
  /// RESOURCE_EXHAUSTED if the queue is full, with the details that the client shall see.
  virtual absl::StatusOr<Ticket> submit(FrameJob job) = 0;
  /// True if the job had not begun; it never will then.
  virtual bool withdraw(Ticket ticket) = 0;
  /// How long a worker needs for a cloud of so many points, judged by earlier ones of the stream.
  virtual std::chrono::nanoseconds expected_time(std::uint64_t points) const = 0;
};

}  // namespace segserve::server
