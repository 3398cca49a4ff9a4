// SPDX-License-Identifier: Apache-2.0
#include "client/stream/stream_message.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "proto/wire/options_message.hpp"
#include "proto/wire/prompts_message.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/track_message.hpp"

namespace segserve::client {
namespace {

template <typename Duration>
google::protobuf::Duration to_message(Duration duration) {
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
  google::protobuf::Duration message;
  message.set_seconds(nanoseconds / 1'000'000'000);
  message.set_nanos(static_cast<std::int32_t>(nanoseconds % 1'000'000'000));
  return message;
}

google::protobuf::Timestamp to_message(std::chrono::system_clock::time_point time) {
  const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  const auto seconds = std::chrono::floor<std::chrono::seconds>(nanoseconds);
  google::protobuf::Timestamp message;
  message.set_seconds(seconds.count());
  message.set_nanos(static_cast<std::int32_t>((nanoseconds - seconds).count()));
  return message;
}

v1::WhenBehind to_message(WhenBehind when) {
  switch (when) {
    case WhenBehind::kDropOldest:
      return v1::WHEN_BEHIND_DROP_OLDEST;
    case WhenBehind::kReject:
      return v1::WHEN_BEHIND_REJECT;
    case WhenBehind::kBlock:
      return v1::WHEN_BEHIND_BLOCK;
  }
  return v1::WHEN_BEHIND_BLOCK;
}

}  // namespace

v1::StreamOpen open_message(const StreamOptions& options) {
  v1::StreamOpen open;
  open.set_client_name(options.client_name);
  *open.mutable_options() = wire::to_message(options.options);
  *open.mutable_outputs() = wire::to_message(options.outputs);
  // Frames may be sent twice, so that only this side can keep the order in which they were handed over.
  open.set_order(v1::RESULT_ORDER_UNORDERED);
  open.set_when_behind(to_message(options.when_behind));
  open.mutable_wanted()->set_frames(static_cast<std::uint32_t>(options.max_in_flight));
  open.mutable_wanted()->set_bytes(options.wanted_bytes);
  return open;
}

v1::FrameHeader header_message(const FrameRequest& request, const StreamOptions& stream, Time end, Time now) {
  v1::FrameHeader header;
  header.set_request_id(request.request_id);
  header.set_frame_id(request.frame_id);
  header.set_traceparent(request.traceparent);
  if (request.stamp) *header.mutable_stamp() = to_message(*request.stamp);
  if (request.options != stream.options) *header.mutable_options() = wire::to_message(request.options);
  if (request.outputs != stream.outputs) *header.mutable_outputs() = wire::to_message(request.outputs);
  if (request.prompts) *header.mutable_prompts() = wire::to_message(*request.prompts);
  if (request.tracking) *header.mutable_tracking() = wire::to_message(*request.tracking);
  *header.mutable_time_to_live() = to_message(std::max(end - request.captured, Clock::duration(0)));
  *header.mutable_age() = to_message(now - request.captured);
  header.set_priority(request.priority);
  return header;
}

OutcomeKind from_message(v1::OutcomeKind kind) {
  switch (kind) {
    case v1::OUTCOME_KIND_RESULT:
      return OutcomeKind::kResult;
    case v1::OUTCOME_KIND_DROPPED:
      return OutcomeKind::kDropped;
    case v1::OUTCOME_KIND_EXPIRED:
      return OutcomeKind::kExpired;
    case v1::OUTCOME_KIND_CANCELLED:
      return OutcomeKind::kCancelled;
    default:
      return OutcomeKind::kFailed;
  }
}

absl::Status status_of(OutcomeKind kind) {
  switch (kind) {
    case OutcomeKind::kDropped:
      return absl::ResourceExhaustedError("a newer frame came");
    case OutcomeKind::kExpired:
      return absl::DeadlineExceededError("the frame's time to live was over, or too little of it was left");
    case OutcomeKind::kCancelled:
      return absl::CancelledError("the frame was cancelled");
    default:
      return absl::OkStatus();
  }
}

}  // namespace segserve::client
