// SPDX-License-Identifier: Apache-2.0
#include "server/observe/frame_trace.hpp"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "proto/wire/traceparent.hpp"

namespace segserve::server {
namespace {

/// Decides by the last 63 bits of the identifier, as OpenTelemetry's TraceIdRatioBased does.
bool is_in_share(std::string_view trace_id, double share) {
  constexpr std::size_t kDigits = 16;
  const std::string_view last = trace_id.substr(trace_id.size() - kDigits);
  std::uint64_t number = 0;
  std::from_chars(last.data(), last.data() + last.size(), number, 16);
  return std::ldexp(static_cast<double>(number >> 1U), -63) < share;
}

}  // namespace

FrameTrace trace_of(std::string_view traceparent, std::optional<double> sampled_share) {
  FrameTrace trace;
  if (const auto client = wire::parse_traceparent(traceparent)) {
    trace.trace_id = client->trace_id;
    trace.parent_id = client->span_id;
    if (sampled_share && client->is_sampled) trace.span_id = wire::new_span_id();
  } else if (sampled_share) {
    const std::string trace_id = wire::new_trace_id();
    if (is_in_share(trace_id, *sampled_share))
      trace = {.trace_id = trace_id, .parent_id = {}, .span_id = wire::new_span_id()};
  }
  return trace;
}

}  // namespace segserve::server
