// SPDX-License-Identifier: Apache-2.0
#include "server/traces/frame_spans.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

constexpr std::int64_t kArrivalNs = 1'800'000'000'000'000'000;

/// A frame of a stream that went all the way.
TracedFrame whole_frame() {
  TracedFrame traced;
  FrameRecord& frame = traced.frame;
  const FrameRecord::Time arrival(100s);
  traced.unix_epoch = arrival.time_since_epoch() - std::chrono::nanoseconds(kArrivalNs);
  traced.trace = {
      .trace_id = "4bf92f3577b34da6a3ce929d0e0e4736", .parent_id = "00f067aa0ba902b7", .span_id = "1111222233334444"};
  frame.caller = std::make_shared<Caller>(Caller{.peer = "ipv4:192.0.2.7:40312", .client_name = "robot"});
  frame.request_id = "scan 7";
  frame.sequence = 7;
  frame.payload_kind = v1::PAYLOAD_KIND_PLANAR;
  frame.received_bytes = 1000;
  frame.sent_bytes = 2000;
  frame.arrival = arrival;
  frame.uploaded = frame.queued = arrival + 10ms;
  frame.work.started = arrival + 15ms;
  frame.work.decoded = arrival + 18ms;
  frame.work.segmented = arrival + 38ms;
  frame.work.encoded = arrival + 40ms;
  frame.work.stages = {.voxels = 2, .normals = 3, .supervoxels = 4, .graph = 1, .merging = 5, .labels = 4, .total = 19};
  frame.work.points = 300;
  frame.decided = arrival + 41ms;
  frame.delivered = arrival + 45ms;
  frame.outcome = v1::OUTCOME_KIND_RESULT;
  return traced;
}

std::vector<std::string> names_of(const std::vector<Span>& spans) {
  std::vector<std::string> names;
  for (const Span& span : spans) names.push_back(span.name);
  return names;
}

/// The value of an attribute as text.
std::string attribute(const Span& span, const std::string& key) {
  const auto found = std::ranges::find(span.attributes, key, &SpanAttribute::key);
  if (found == span.attributes.end()) return "";
  const auto* text = std::get_if<std::string>(&found->value);
  return text != nullptr ? *text : std::to_string(std::get<std::int64_t>(found->value));
}

TEST(FrameSpans, AreTheStepsOfAFrameWithTheStagesOfTheCore) {
  const auto spans = spans_of(whole_frame());
  EXPECT_THAT(names_of(spans),
              ElementsAre("segserve.segment", "upload", "queue", "decode", "segment", "voxels", "normals",
                          "supervoxels", "graph", "merging", "labels", "encode", "deliver"));
  std::map<std::string, Span> by_id;
  for (const Span& span : spans) {
    EXPECT_EQ(span.trace_id, "4bf92f3577b34da6a3ce929d0e0e4736");
    by_id[span.span_id] = span;
  }
  EXPECT_EQ(by_id.size(), spans.size());
  const Span& root = spans.front();
  EXPECT_EQ(root.span_id, "1111222233334444");
  EXPECT_EQ(root.parent_id, "00f067aa0ba902b7");
  EXPECT_EQ(root.kind, Span::Kind::kServer);
  EXPECT_EQ(root.begin_ns, kArrivalNs);
  EXPECT_EQ(root.end_ns - root.begin_ns, std::chrono::nanoseconds(45ms).count());
  const std::set<std::string> stages = {"voxels", "normals", "supervoxels", "graph", "merging", "labels"};
  for (const Span& span : spans) {
    if (&span == &root) continue;
    const Span& parent = by_id.at(span.parent_id);
    EXPECT_EQ(parent.name, stages.contains(span.name) ? "segment" : "segserve.segment");
    EXPECT_GE(span.begin_ns, parent.begin_ns);
    EXPECT_LE(span.end_ns, parent.end_ns);
    EXPECT_LT(span.begin_ns, span.end_ns);
    EXPECT_EQ(span.kind, Span::Kind::kInternal);
  }
}

TEST(FrameSpans, DescribeTheFrameByTheConventions) {
  const Span root = spans_of(whole_frame()).front();
  EXPECT_EQ(attribute(root, "rpc.system"), "grpc");
  EXPECT_EQ(attribute(root, "rpc.service"), "segserve.v1.SegmentationService");
  EXPECT_EQ(attribute(root, "rpc.method"), "SegmentStream");
  EXPECT_EQ(attribute(root, "rpc.grpc.status_code"), "0");
  EXPECT_EQ(attribute(root, "network.peer.address"), "192.0.2.7");
  EXPECT_EQ(attribute(root, "network.peer.port"), "40312");
  EXPECT_EQ(attribute(root, "segserve.outcome"), "RESULT");
  EXPECT_EQ(attribute(root, "segserve.request_id"), "scan 7");
  EXPECT_EQ(attribute(root, "segserve.client"), "robot");
  EXPECT_EQ(attribute(root, "segserve.sequence"), "7");
  EXPECT_EQ(attribute(root, "segserve.payload"), "planar");
  EXPECT_EQ(attribute(root, "segserve.points"), "300");
  EXPECT_EQ(attribute(root, "error.type"), "");
  EXPECT_FALSE(root.is_error);
}

TEST(FrameSpans, OfAUnaryCallHaveNoUpload) {
  TracedFrame traced = whole_frame();
  traced.frame.call = FrameRecord::Call::kUnary;
  traced.frame.uploaded = traced.frame.arrival;
  traced.frame.delivered.reset();
  const auto spans = spans_of(traced);
  EXPECT_THAT(names_of(spans), testing::Not(testing::Contains(testing::AnyOf("upload", "deliver"))));
  EXPECT_EQ(attribute(spans.front(), "rpc.method"), "Segment");
  EXPECT_EQ(attribute(spans.front(), "segserve.sequence"), "");
  EXPECT_EQ(spans.front().end_ns - spans.front().begin_ns, std::chrono::nanoseconds(41ms).count());
}

TEST(FrameSpans, EndWithTheFrameWhereItEnded) {
  TracedFrame traced = whole_frame();
  FrameRecord& frame = traced.frame;
  frame.work.segmented.reset();
  frame.work.encoded.reset();
  frame.delivered.reset();
  frame.outcome = v1::OUTCOME_KIND_FAILED;
  frame.status = {.code = absl::StatusCode::kInternal, .reason = wire::ErrorReason::kInternal, .message = "a fault"};
  const auto spans = spans_of(traced);
  EXPECT_THAT(names_of(spans), ElementsAre("segserve.segment", "upload", "queue", "decode", "segment"));
  EXPECT_EQ(spans.back().end_ns, spans.front().end_ns);
  EXPECT_TRUE(spans.front().is_error);
  EXPECT_EQ(spans.front().error, "a fault");
  EXPECT_EQ(attribute(spans.front(), "error.type"), "INTERNAL");
  EXPECT_EQ(attribute(spans.front(), "segserve.segments"), "");
}

TEST(FrameSpans, CallTheClientsFaultNoErrorOfTheServer) {
  TracedFrame traced = whole_frame();
  traced.frame.outcome = v1::OUTCOME_KIND_FAILED;
  traced.frame.status = {.code = absl::StatusCode::kInvalidArgument, .reason = wire::ErrorReason::kInvalidField};
  const Span root = spans_of(traced).front();
  EXPECT_FALSE(root.is_error);
  EXPECT_EQ(attribute(root, "error.type"), "INVALID_FIELD");
  EXPECT_EQ(attribute(root, "rpc.grpc.status_code"), "3");
}

TEST(FrameSpans, StayWithinTheirParentWhateverTheStagesSay) {
  TracedFrame traced = whole_frame();
  traced.frame.work.stages.voxels = 1e9;
  const auto spans = spans_of(traced);
  for (const Span& span : spans) EXPECT_LE(span.end_ns, spans.front().end_ns);
}

TEST(FrameSpans, KeepNoLongTexts) {
  FrameRecord frame = whole_frame().frame;
  const std::string text(1'000'000, 'x');
  frame.request_id = frame.traceparent = frame.status.message = text;
  const TracedFrame traced = traced_now(std::move(frame), {});
  for (const std::string& kept : {traced.frame.request_id, traced.frame.traceparent, traced.frame.status.message}) {
    EXPECT_EQ(kept.size(), kMostTracedBytes);
  }
}

TEST(FrameSpans, BeginAtTheTimeOfTheDay) {
  FrameRecord frame = whole_frame().frame;
  frame.arrival = FrameRecord::Time::clock::now();
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::int64_t begin = spans_of(traced_now(std::move(frame), {})).front().begin_ns;
  EXPECT_NEAR(static_cast<double>(begin), static_cast<double>(std::chrono::nanoseconds(now).count()), 1e9);
}

TEST(FrameSpans, TellsPeersOfAllKinds) {
  TracedFrame traced = whole_frame();
  const auto address = [&](const std::string& peer) {
    traced.frame.caller = std::make_shared<Caller>(Caller{.peer = peer});
    const Span root = spans_of(traced).front();
    return attribute(root, "network.peer.address") + " " + attribute(root, "network.peer.port") + " " +
           attribute(root, "network.transport");
  };
  EXPECT_EQ(address("ipv6:%5B::1%5D:50051"), "%5B::1%5D 50051 ");
  EXPECT_EQ(address("unix:/run/segserve.sock"), "  unix");
  EXPECT_EQ(address("unix:"), "  unix");
  EXPECT_EQ(address(""), "  ");
  EXPECT_EQ(address("ip"), "  ");
}

}  // namespace
}  // namespace segserve::server
