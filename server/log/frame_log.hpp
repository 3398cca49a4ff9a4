// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "server/log/event_limiter.hpp"
#include "server/observe/frame_record.hpp"
#include "server/observe/frame_trace.hpp"
#include "server/scheduling/ticker.hpp"

namespace segserve::server {

/// Writes to the log what becomes of frames and streams: a line for each at level debug. At level info there is a line
/// for the first of each kind that did not get what its client wanted, and every `period` one that counts the others.
/// Thread-safe.
class FrameLog {
 public:
  explicit FrameLog(std::chrono::milliseconds period = std::chrono::seconds(10));
  /// Tells what has been counted since.
  ~FrameLog();
  FrameLog(const FrameLog&) = delete;
  FrameLog& operator=(const FrameLog&) = delete;

  void write(const FrameRecord& frame, const FrameTrace& trace);
  void write(const StreamRecord& stream, const FrameTrace& trace);
  void write(const RefusedQuestion& question);

 private:
  const std::chrono::milliseconds period_;
  EventLimiter limiter_;
  Ticker ticker_;  // is destroyed first
};

}  // namespace segserve::server
