// SPDX-License-Identifier: Apache-2.0
#include "client/stream/frame_request.hpp"

#include <algorithm>
#include <utility>

namespace segserve::client {

std::optional<Time> FrameRequest::expires() const {
  if (!time_to_live) return std::nullopt;
  return captured + *time_to_live;
}

namespace {

double seconds_of(const FrameOptions& frame, Time captured) {
  const auto seconds = [](auto duration) { return std::chrono::duration<double>(duration).count(); };
  return frame.stamp ? seconds(frame.stamp->time_since_epoch()) : seconds(captured.time_since_epoch());
}

std::optional<wire::TrackRequest> resolve_tracking(const FrameOptions& frame, const StreamOptions& stream,
                                                   Time captured) {
  if (!stream.tracking) return frame.tracking;
  wire::TrackRequest request{.options = *stream.tracking, .state = {}};
  request.options.pose = frame.pose;
  request.options.time = seconds_of(frame, captured);
  return request;
}

}  // namespace

FrameRequest resolve(Payload payload, FrameOptions frame, const StreamOptions& stream, Time now) {
  const Time captured = std::min(frame.captured.value_or(now), now);
  return {.payload = std::move(payload),
          .options = frame.options.value_or(stream.options),
          .outputs = frame.outputs.value_or(stream.outputs),
          .prompts = std::move(frame.prompts),
          .tracking = resolve_tracking(frame, stream, captured),
          .request_id = std::move(frame.request_id),
          .frame_id = std::move(frame.frame_id),
          .traceparent = std::move(frame.traceparent),
          .stamp = frame.stamp,
          .captured = captured,
          .time_to_live = frame.time_to_live,
          .priority = frame.priority,
          .timeout = frame.timeout.value_or(stream.frame_timeout)};
}

}  // namespace segserve::client
