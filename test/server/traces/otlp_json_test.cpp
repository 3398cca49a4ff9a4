// SPDX-License-Identifier: Apache-2.0
#include "server/traces/otlp_json.hpp"

#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace segserve::server {
namespace {

TEST(OtlpJson, IsAnExportTraceServiceRequest) {
  Span span{.trace_id = "4bf92f3577b34da6a3ce929d0e0e4736", .span_id = "1111222233334444", .name = "upload"};
  span.parent_id = "00f067aa0ba902b7";
  span.begin_ns = 1'800'000'000'000'000'001;
  span.end_ns = 1'800'000'000'000'000'002;
  span.attributes = {{"text", "a \"b\" \xff"}, {"number", std::int64_t{1} << 60U}};
  const auto json = nlohmann::json::parse(export_request({{"service.name", "segserve"}}, {span}));
  EXPECT_EQ(json["resourceSpans"][0]["resource"]["attributes"],
            nlohmann::json::parse(R"([{"key": "service.name", "value": {"stringValue": "segserve"}}])"));
  EXPECT_EQ(json["resourceSpans"][0]["scopeSpans"][0]["scope"]["name"], "segserve");
  EXPECT_EQ(json["resourceSpans"][0]["scopeSpans"][0]["spans"], nlohmann::json::parse(R"([{
    "traceId": "4bf92f3577b34da6a3ce929d0e0e4736", "spanId": "1111222233334444", "parentSpanId": "00f067aa0ba902b7",
    "name": "upload", "kind": 1,
    "startTimeUnixNano": "1800000000000000001", "endTimeUnixNano": "1800000000000000002",
    "attributes": [{"key": "text", "value": {"stringValue": "a \"b\" \ufffd"}},
                   {"key": "number", "value": {"intValue": "1152921504606846976"}}]}])"));
}

TEST(OtlpJson, HasAStatusForErrorsOnly) {
  Span span{.trace_id = "4bf92f3577b34da6a3ce929d0e0e4736", .span_id = "1111222233334444", .name = "segserve.segment"};
  span.kind = Span::Kind::kServer;
  const auto of_span = [&span] {
    return nlohmann::json::parse(export_request({}, {span}))["resourceSpans"][0]["scopeSpans"][0]["spans"][0];
  };
  EXPECT_FALSE(of_span().contains("status"));
  EXPECT_FALSE(of_span().contains("parentSpanId"));
  EXPECT_EQ(of_span()["kind"], 2);
  span.is_error = true;
  span.error = "a fault";
  EXPECT_EQ(of_span()["status"], nlohmann::json::parse(R"({"code": 2, "message": "a fault"})"));
}

TEST(OtlpJson, ReadsWhatTheCollectorComplainsOf) {
  EXPECT_EQ(partial_failure(R"({"partialSuccess": {"rejectedSpans": "5", "errorMessage": "too old"}})"),
            "the collector rejected 5 spans: too old");
  EXPECT_EQ(partial_failure(R"({"partialSuccess": {"rejectedSpans": 5}})"), "the collector rejected 5 spans: ");
  for (const char* good : {"", "{}", "{", "[]", "\xff", R"({"partialSuccess": {}})", R"({"partialSuccess": null})",
                           R"({"partialSuccess": {"rejectedSpans": "0"}})"}) {
    EXPECT_EQ(partial_failure(good), std::nullopt) << good;
  }
}

}  // namespace
}  // namespace segserve::server
