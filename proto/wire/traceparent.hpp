// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

// The context of a distributed trace, as W3C's "Trace Context" writes it:
// 00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01
namespace segserve::wire {

/// The name of the metadata that carries it in a call.
inline constexpr char kTraceparentKey[] = "traceparent";

/// Identifiers are lower-case hexadecimal digits.
struct Traceparent {
  std::string trace_id;     ///< 32 digits, not all 0
  std::string span_id;      ///< 16 digits, not all 0: the caller's span
  bool is_sampled = false;  ///< the caller records this trace
};

/// Nothing unless the text is exactly of version 00.
std::optional<Traceparent> parse_traceparent(std::string_view text);

std::string to_text(const Traceparent& traceparent);

/// OK if the text is empty or a traceparent of version 00; else INVALID_ARGUMENT.
absl::Status check_traceparent(std::string_view text);

/// Random identifiers for a new trace and a new span. They are unpredictable enough to be unique, but are no secrets.
std::string new_trace_id();
std::string new_span_id();

}  // namespace segserve::wire
