// SPDX-License-Identifier: Apache-2.0
#include "client/stream/frame_request.hpp"

#include <algorithm>
#include <utility>

namespace segserve::client {

std::optional<Time> FrameRequest::expires() const {
  if (!time_to_live) return std::nullopt;
  return captured + *time_to_live;
}

FrameRequest resolve(Payload payload, FrameOptions frame, const StreamOptions& stream, Time now) {
  return {.payload = std::move(payload),
          .options = frame.options.value_or(stream.options),
          .outputs = frame.outputs.value_or(stream.outputs),
          .request_id = std::move(frame.request_id),
          .frame_id = std::move(frame.frame_id),
          .stamp = frame.stamp,
          .captured = std::min(frame.captured.value_or(now), now),
          .time_to_live = frame.time_to_live,
          .priority = frame.priority,
          .timeout = frame.timeout.value_or(stream.frame_timeout)};
}

}  // namespace segserve::client
