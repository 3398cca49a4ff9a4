// SPDX-License-Identifier: Apache-2.0
#include "server/observe/frame_record.hpp"

#include <memory>
#include <utility>

#include "core/base/status_text.hpp"
#include "proto/wire/status_message.hpp"

namespace segserve::server {
namespace {

v1::OutcomeKind outcome_of_call(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kOk:
      return v1::OUTCOME_KIND_RESULT;
    case absl::StatusCode::kCancelled:
      return v1::OUTCOME_KIND_CANCELLED;
    case absl::StatusCode::kDeadlineExceeded:
      return v1::OUTCOME_KIND_EXPIRED;
    default:
      return v1::OUTCOME_KIND_FAILED;
  }
}

}  // namespace

StatusFacts facts_of(const absl::Status& status) noexcept {
  if (status.ok()) return {};
  try {
    const absl::Status told = wire::as_told(status);
    const wire::ErrorDetails details = wire::details_of(told);
    const auto limit = details.metadata.find("limit");
    return {.code = told.code(),
            .reason = details.reason,
            .limit = limit == details.metadata.end() ? "" : limit->second,
            .message = message_of(told)};
  } catch (...) {
    return {.code = status.code()};
  }
}

FrameRecord arriving_call(Caller caller, FrameRecord::Time now) {
  FrameRecord frame;
  frame.call = FrameRecord::Call::kUnary;
  frame.traceparent = caller.traceparent;
  frame.caller = std::make_shared<const Caller>(std::move(caller));
  frame.arrival = now;
  frame.uploaded = now;
  return frame;
}

void end_call(FrameRecord& frame, const absl::Status& status, FrameRecord::Time now) noexcept {
  frame.status = facts_of(status);
  frame.outcome = outcome_of_call(frame.status.code);
  frame.decided = now;
  frame.delivered = now;
}

void end_with_stream(FrameRecord& frame, const absl::Status& status, FrameRecord::Time now) noexcept {
  const bool has_outcome = frame.outcome != v1::OUTCOME_KIND_UNSPECIFIED;
  if (!has_outcome) frame.decided = now;
  frame.status = facts_of(status);
  frame.outcome = absl::IsCancelled(status) ? v1::OUTCOME_KIND_CANCELLED : v1::OUTCOME_KIND_FAILED;
}

}  // namespace segserve::server
