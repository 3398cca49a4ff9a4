// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/traces/span.hpp"

// The JSON encoding of OTLP, OpenTelemetry's protocol (opentelemetry.io/docs/specs/otlp, "JSON Protobuf Encoding").
namespace segserve::server {

/// An ExportTraceServiceRequest: spans of a process that the resource describes. Bytes that are no UTF-8 become U+FFFD.
std::string export_request(const std::vector<SpanAttribute>& resource, const std::vector<Span>& spans);

/// Reads the complaint of an ExportTraceServiceResponse. There is none if it took all spans, or is no such message.
std::optional<std::string> partial_failure(std::string_view response);

}  // namespace segserve::server
