// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "server/observe/frame_record.hpp"
#include "server/observe/frame_trace.hpp"
#include "server/traces/span.hpp"

namespace segserve::server {

/// A frame that is recorded, until its spans are made.
struct TracedFrame {
  FrameRecord frame;                    ///< its texts have at most kMostTracedBytes
  FrameTrace trace;                     ///< its span_id is set
  std::chrono::nanoseconds unix_epoch;  ///< 1970 by the steady clock that the frame's times are of
};

/// The most bytes of a text in a span.
inline constexpr std::size_t kMostTracedBytes = 256;

/// Texts of clients, which may be as large as a message if the frame failed because of them, are cut.
TracedFrame traced_now(FrameRecord frame, FrameTrace trace);

/// The spans of a frame: `segserve.segment` first, its children `upload`, `queue`, `decode`, `segment`, `encode` and
/// `deliver` as far as the frame got, and as children of `segment` the stages of the core. What was under way when the
/// frame ended, ends with it.
std::vector<Span> spans_of(const TracedFrame& traced);

}  // namespace segserve::server
