// SPDX-License-Identifier: Apache-2.0
#include "server/log/frame_log.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/log/log_event.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

using Level = spdlog::level::level_enum;
using Fields = std::vector<LogField>;
using OptionalTime = std::optional<FrameRecord::Time>;

constexpr std::chrono::milliseconds kLongestTick{1000};

bool is_refusal(absl::StatusCode code) {
  return code == absl::StatusCode::kResourceExhausted || code == absl::StatusCode::kUnavailable ||
         code == absl::StatusCode::kUnauthenticated || code == absl::StatusCode::kPermissionDenied;
}

/// How a frame ended that an operator should know of; empty for others.
std::string_view trouble_of(const FrameRecord& frame) {
  if (frame.is_evicted) return "frame evicted from the queue";
  switch (frame.outcome) {
    case v1::OUTCOME_KIND_FAILED:
      return is_refusal(frame.status.code) ? "frame refused" : "frame failed";
    case v1::OUTCOME_KIND_DROPPED:
      return "frame dropped";
    case v1::OUTCOME_KIND_EXPIRED:
      return "frame expired";
    default:
      return "";
  }
}

std::string_view trouble_of(const StreamRecord& stream) {
  const absl::StatusCode code = stream.status.code;
  if (code == absl::StatusCode::kOk || code == absl::StatusCode::kCancelled) return "";
  return stream.is_opened ? "stream failed" : "stream refused";
}

/// "RESULT" for OUTCOME_KIND_RESULT.
std::string_view outcome_name(v1::OutcomeKind outcome) {
  constexpr std::string_view kPrefix = "OUTCOME_KIND_";
  std::string_view name = v1::OutcomeKind_Name(outcome);
  if (name.starts_with(kPrefix)) name.remove_prefix(kPrefix.size());
  return name;
}

EventKind kind_of(std::string_view trouble, const StatusFacts& status) {
  EventKind kind{.what = std::string(trouble), .code = {}, .reason = {}, .limit = status.limit};
  if (status.code != absl::StatusCode::kOk) kind.code = absl::StatusCodeToString(status.code);
  if (status.reason != wire::ErrorReason::kUnspecified) kind.reason = wire::name(status.reason);
  return kind;
}

void add_kind(const EventKind& kind, Fields& fields) {
  fields.insert(fields.end(), {{"code", kind.code}, {"reason", kind.reason}, {"limit", kind.limit}});
}

void add_caller(const Caller& caller, const FrameTrace& trace, Fields& fields) {
  fields.insert(fields.end(), {{"subject", caller.subject},
                               {"client", caller.client_name},
                               {"peer", caller.peer},
                               {"trace_id", trace.trace_id},
                               {"span_id", trace.span_id.empty() ? trace.parent_id : trace.span_id}});
}

/// Adds the time from `begin` to `end`, if both are known.
void add_time(std::string_view name, const OptionalTime& begin, const OptionalTime& end, Fields& fields) {
  if (begin && end) fields.emplace_back(name, std::chrono::duration<double, std::milli>(*end - *begin).count());
}

void add_work(const FrameRecord& frame, Fields& fields) {
  const FrameWork& work = frame.work;
  fields.emplace_back("received_bytes", frame.received_bytes);
  if (work.decoded) fields.emplace_back("points", work.points);
  if (work.encoded) fields.insert(fields.end(), {{"segments", work.segments}, {"sent_bytes", frame.sent_bytes}});
  const bool is_streamed = frame.call == FrameRecord::Call::kStream;
  if (is_streamed) add_time("upload_ms", frame.arrival, frame.uploaded, fields);
  add_time("queue_ms", frame.queued, work.started, fields);
  add_time("decode_ms", work.started, work.decoded, fields);
  add_time("segment_ms", work.decoded, work.segmented, fields);
  add_time("encode_ms", work.segmented, work.encoded, fields);
  if (is_streamed) add_time("deliver_ms", frame.decided, frame.delivered, fields);
  add_time("total_ms", frame.arrival, frame.delivered.value_or(frame.decided), fields);
}

/// The level of a line: that of trouble if it is the first of its kind for a while, else debug.
Level level_of(const EventKind& kind, EventLimiter& limiter) {
  const bool is_shown = !kind.what.empty() && limiter.admit(kind, EventLimiter::Time::clock::now());
  if (!is_shown) return Level::debug;
  return kind.code == "INTERNAL" ? Level::warn : Level::info;
}

void write_summaries(const std::vector<EventLimiter::Summary>& summaries, std::chrono::milliseconds period) {
  for (const auto& [kind, count] : summaries) {
    Fields fields{{"count", count}};
    add_kind(kind, fields);
    log_event(
        Level::info,
        fmt::format("{}: {} more in the last {:g} s", kind.what, count, std::chrono::duration<double>(period).count()),
        fields);
  }
}

}  // namespace

FrameLog::FrameLog(std::chrono::milliseconds period)
    : period_(period), limiter_(period), ticker_(std::min(period, kLongestTick), [this] {
        const absl::Status told = catch_exceptions("tell what was refused", [this] {
          write_summaries(limiter_.due(EventLimiter::Time::clock::now()), period_);
          return absl::OkStatus();
        });
        told.IgnoreError();  // it is in the log
        return true;
      }) {}

FrameLog::~FrameLog() {
  const absl::Status told = catch_exceptions("tell what was refused", [this] {
    write_summaries(limiter_.rest(), period_);
    return absl::OkStatus();
  });
  told.IgnoreError();  // it is in the log
}

void FrameLog::write(const FrameRecord& frame, const FrameTrace& trace) {
  const EventKind kind = kind_of(trouble_of(frame), frame.status);
  const Level level = level_of(kind, limiter_);
  if (!spdlog::should_log(level)) return;
  const bool is_unary = frame.call == FrameRecord::Call::kUnary;
  Fields fields{{"outcome", outcome_name(frame.outcome)}};
  add_kind(kind, fields);
  fields.insert(fields.end(), {{"error", frame.status.message},
                               {"call", is_unary ? "Segment" : "SegmentStream"},
                               {"request_id", frame.request_id}});
  if (!is_unary) fields.emplace_back("sequence", frame.sequence);
  add_caller(*frame.caller, trace, fields);
  fields.emplace_back("payload", wire::name(frame.payload_kind));
  add_work(frame, fields);
  log_event(level, kind.what.empty() ? "frame" : kind.what, fields);
}

void FrameLog::write(const StreamRecord& stream, const FrameTrace& trace) {
  const EventKind kind = kind_of(trouble_of(stream), stream.status);
  const Level level = level_of(kind, limiter_);
  if (!spdlog::should_log(level)) return;
  Fields fields;
  add_kind(kind, fields);
  fields.emplace_back("error", stream.status.message);
  add_caller(*stream.caller, trace, fields);
  fields.emplace_back("frames", stream.frames);
  add_time("total_ms", stream.began, stream.ended, fields);
  log_event(level, kind.what.empty() ? "stream" : kind.what, fields);
}

void FrameLog::write(const RefusedQuestion& question) {
  const EventKind kind = kind_of("question refused", question.status);
  const Level level = level_of(kind, limiter_);
  if (!spdlog::should_log(level)) return;
  Fields fields;
  add_kind(kind, fields);
  fields.insert(fields.end(), {{"error", question.status.message}, {"call", question.rpc}});
  add_caller(*question.caller, {}, fields);
  log_event(level, kind.what, fields);
}

}  // namespace segserve::server
