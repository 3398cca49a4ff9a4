#pragma once

#include <cstdint>
#include <functional>

#include "absl/status/statusor.h"
#include "server/frames/segmentation_backend.hpp"

namespace segserve::server {

/// One frame as the workers see it.
struct FrameJob {
  std::int32_t priority = 0;
  std::uint64_t points = 0;  ///< as far as they are known before the payload is decoded
  std::uint64_t bytes = 0;   ///< of the payload
  /// true: queue it even if the queue is full. The stream's credit has bounded such frames before they came.
  bool may_exceed_queue = false;
  /// Must not throw.
  std::function<void(SegmentationBackend&)> run;
};

/// Where the frames of a stream are computed: the worker pool, or a test. No function waits for a job, and none calls
/// one before it returns.
class FrameExecutor {
 public:
  using Ticket = std::uint64_t;

  virtual ~FrameExecutor() = default;
  /// RESOURCE_EXHAUSTED, with the details that the client shall see, if the queue is full.
  virtual absl::StatusOr<Ticket> submit(FrameJob job) = 0;
  /// True if the job had not begun; then it never will.
  virtual bool withdraw(Ticket ticket) = 0;
};

}  // namespace segserve::server
