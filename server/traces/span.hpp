// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace segserve::server {

/// A fact about a span or about the process, by OpenTelemetry's name for it.
struct SpanAttribute {
  std::string key;
  std::variant<std::string, std::int64_t> value;
};

/// A span of OpenTelemetry: a piece of work within a trace. Identifiers are lower-case hexadecimal digits.
struct Span {
  enum class Kind : std::uint8_t { kInternal = 1, kServer = 2 };  // the numbers of OTLP

  std::string trace_id, span_id;
  std::string parent_id = {};  ///< empty: the trace begins here
  std::string name;
  Kind kind = Kind::kInternal;
  std::int64_t begin_ns = 0, end_ns = 0;  ///< nanoseconds since 1970
  std::vector<SpanAttribute> attributes = {};
  bool is_error = false;
  std::string error = {};  ///< for people; set only with is_error
};

}  // namespace segserve::server
