// SPDX-License-Identifier: Apache-2.0
#include "server/traces/otlp_json.hpp"

#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "server/version.hpp"

namespace segserve::server {
namespace {

using Json = nlohmann::json;

constexpr int kStatusError = 2;

/// In this encoding integers of 64 bits are texts.
Json attributes_json(const std::vector<SpanAttribute>& attributes) {
  Json list = Json::array();
  for (const auto& [key, value] : attributes) {
    if (const auto* text = std::get_if<std::string>(&value)) {
      list.push_back({{"key", key}, {"value", {{"stringValue", *text}}}});
    } else {
      list.push_back({{"key", key}, {"value", {{"intValue", std::to_string(std::get<std::int64_t>(value))}}}});
    }
  }
  return list;
}

Json span_json(const Span& span) {
  Json json = {{"traceId", span.trace_id},
               {"spanId", span.span_id},
               {"name", span.name},
               {"kind", static_cast<int>(span.kind)},
               {"startTimeUnixNano", std::to_string(span.begin_ns)},
               {"endTimeUnixNano", std::to_string(span.end_ns)}};
  if (!span.parent_id.empty()) json["parentSpanId"] = span.parent_id;
  if (!span.attributes.empty()) json["attributes"] = attributes_json(span.attributes);
  if (span.is_error) json["status"] = {{"code", kStatusError}, {"message", span.error}};
  return json;
}

}  // namespace

std::string export_request(const std::vector<SpanAttribute>& resource, const std::vector<Span>& spans) {
  Json list = Json::array();
  for (const Span& span : spans) list.push_back(span_json(span));
  Json scope_spans = {{"scope", {{"name", "segserve"}, {"version", kVersion}}}, {"spans", std::move(list)}};
  Json resource_spans = {{"resource", {{"attributes", attributes_json(resource)}}},
                         {"scopeSpans", Json::array({std::move(scope_spans)})}};
  const Json request = {{"resourceSpans", Json::array({std::move(resource_spans)})}};
  return request.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<std::string> partial_failure(std::string_view response) {
  const Json json = Json::parse(response, nullptr, false);
  if (!json.is_object() || !json.contains("partialSuccess")) return std::nullopt;
  const Json& partial = json.at("partialSuccess");
  if (!partial.is_object()) return std::nullopt;
  const auto text_of = [&partial](const char* name) {
    if (!partial.contains(name)) return std::string();
    const Json& value = partial.at(name);
    return value.is_string() ? value.get<std::string>() : value.dump();
  };
  const std::string rejected = text_of("rejectedSpans"), message = text_of("errorMessage");
  if ((rejected.empty() || rejected == "0") && message.empty()) return std::nullopt;
  return fmt::format("the collector rejected {} spans: {}", rejected.empty() ? "0" : rejected, message);
}

}  // namespace segserve::server
