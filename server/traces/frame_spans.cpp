// SPDX-License-Identifier: Apache-2.0
#include "server/traces/frame_spans.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/numbers.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/traceparent.hpp"

namespace segserve::server {
namespace {

using Time = FrameRecord::Time;
using OptionalTime = std::optional<Time>;

/// Adds the spans of one frame to a list.
class SpanMaker {
 public:
  explicit SpanMaker(const TracedFrame& traced) : traced_(traced) {}

  /// Returns the identifier of the span. A span that would take no time is left out.
  std::string add(const std::string& parent_id, std::string_view name, Time begin, Time end) {
    if (end <= begin) return parent_id;
    Span span = make(name, begin, end);
    span.span_id = wire::new_span_id();
    span.parent_id = parent_id;
    spans_.push_back(std::move(span));
    return spans_.back().span_id;
  }

  Span& add_root(std::string_view name, Time begin, Time end) {
    Span span = make(name, begin, end);
    span.span_id = traced_.trace.span_id;
    span.parent_id = traced_.trace.parent_id;
    span.kind = Span::Kind::kServer;
    return spans_.emplace_back(std::move(span));
  }

  std::vector<Span> take() { return std::move(spans_); }

 private:
  Span make(std::string_view name, Time begin, Time end) const {
    return {.trace_id = traced_.trace.trace_id,
            .span_id = {},
            .name = std::string(name),
            .begin_ns = unix_ns(begin),
            .end_ns = unix_ns(end)};
  }
  std::int64_t unix_ns(Time time) const {
    return std::chrono::nanoseconds(time.time_since_epoch() - traced_.unix_epoch).count();
  }

  const TracedFrame& traced_;
  std::vector<Span> spans_;
};

/// The codes for which OpenTelemetry's conventions call the span of a server an error: it is not the client's fault.
bool is_servers_fault(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDataLoss:
      return true;
    default:
      return false;
  }
}

void add_text(std::string key, std::string_view text, Span& span) {
  if (!text.empty()) span.attributes.push_back({std::move(key), std::string(text)});
}

void add_number(std::string key, std::uint64_t number, Span& span) {
  span.attributes.push_back({std::move(key), static_cast<std::int64_t>(number)});
}

/// Adds address and port from gRPC's name of the other end, such as "ipv4:192.0.2.7:40312".
void add_peer(std::string_view peer, Span& span) {
  if (!peer.starts_with("ip")) return add_text("network.transport", peer.starts_with("unix") ? "unix" : "", span);
  const std::size_t begin = peer.find(':') + 1, end = peer.rfind(':');
  int port = 0;
  if (end <= begin || !absl::SimpleAtoi(std::string(peer.substr(end + 1)), &port)) return;
  add_text("network.peer.address", peer.substr(begin, end - begin), span);
  add_number("network.peer.port", static_cast<std::uint64_t>(port), span);
}

void describe_call(const FrameRecord& frame, Span& span) {
  const bool is_unary = frame.call == FrameRecord::Call::kUnary;
  add_text("rpc.system", "grpc", span);
  add_text("rpc.service", "segserve.v1.SegmentationService", span);
  add_text("rpc.method", is_unary ? "Segment" : "SegmentStream", span);
  add_number("rpc.grpc.status_code", static_cast<std::uint64_t>(frame.status.code), span);
  add_peer(frame.caller->peer, span);
  add_text("segserve.client", frame.caller->client_name, span);
  add_text("segserve.subject", frame.caller->subject, span);
  add_text("segserve.request_id", frame.request_id, span);
  if (!is_unary) add_number("segserve.sequence", frame.sequence, span);
}

void describe_outcome(const FrameRecord& frame, Span& span) {
  constexpr std::string_view kPrefix = "OUTCOME_KIND_";
  add_text("segserve.outcome", v1::OutcomeKind_Name(frame.outcome).substr(kPrefix.size()), span);
  add_text("segserve.payload", wire::name(frame.payload_kind), span);
  add_number("segserve.received_bytes", frame.received_bytes, span);
  if (frame.work.decoded) add_number("segserve.points", frame.work.points, span);
  if (frame.work.encoded) {
    add_number("segserve.voxels", frame.work.voxels, span);
    add_number("segserve.supervoxels", frame.work.supervoxels, span);
    add_number("segserve.segments", frame.work.segments, span);
    add_number("segserve.sent_bytes", frame.sent_bytes, span);
  }
  if (frame.status.code != absl::StatusCode::kOk) add_text("error.type", wire::name(frame.status.reason), span);
  span.is_error = is_servers_fault(frame.status.code);
  if (span.is_error) span.error = frame.status.message;
}

void add_stages(const std::string& parent_id, Time begin, Time end, const StageTimings& stages, SpanMaker& maker) {
  const std::pair<std::string_view, double> times[] = {
      {"voxels", stages.voxels},     {"normals", stages.normals},  {"supervoxels", stages.supervoxels},
      {"graph", stages.graph},       {"merging", stages.merging},  {"labels", stages.labels},
      {"tracking", stages.tracking}, {"segments", stages.segments}};
  for (const auto& [name, ms] : times) {
    if (name == "tracking" && ms == 0) continue;  // not asked for
    const auto time = std::chrono::duration_cast<Time::duration>(std::chrono::duration<double, std::milli>(ms));
    const Time stage_end = std::min(begin + time, end);
    maker.add(parent_id, name, begin, stage_end);
    begin = stage_end;
  }
}

void cut(std::string& text) {
  if (text.size() <= kMostTracedBytes) return;
  text.resize(kMostTracedBytes);
  text.shrink_to_fit();
}

}  // namespace

TracedFrame traced_now(FrameRecord frame, FrameTrace trace) {
  cut(frame.request_id);
  cut(frame.traceparent);
  cut(frame.status.message);
  const auto epoch =
      std::chrono::steady_clock::now().time_since_epoch() - std::chrono::system_clock::now().time_since_epoch();
  return {.frame = std::move(frame), .trace = std::move(trace), .unix_epoch = epoch};
}

std::vector<Span> spans_of(const TracedFrame& traced) {
  const FrameRecord& frame = traced.frame;
  const FrameWork& work = frame.work;
  SpanMaker maker(traced);
  Span& root = maker.add_root("segserve.segment", frame.arrival, frame.delivered.value_or(frame.decided));
  describe_call(frame, root);
  describe_outcome(frame, root);
  const std::string& root_id = traced.trace.span_id;
  const auto add_step = [&](std::string_view name, const OptionalTime& begin, const OptionalTime& end) {
    return begin ? maker.add(root_id, name, *begin, end.value_or(frame.decided)) : root_id;
  };
  if (frame.call == FrameRecord::Call::kStream) add_step("upload", frame.arrival, frame.uploaded);
  add_step("queue", frame.queued, work.started);
  add_step("decode", work.started, work.decoded);
  const std::string segment_id = add_step("segment", work.decoded, work.segmented);
  if (work.segmented) add_stages(segment_id, *work.decoded, *work.segmented, work.stages, maker);
  add_step("encode", work.segmented, work.encoded);
  if (frame.delivered) add_step("deliver", frame.decided, frame.delivered);
  return maker.take();
}

}  // namespace segserve::server
