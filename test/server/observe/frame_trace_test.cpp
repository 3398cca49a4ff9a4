// SPDX-License-Identifier: Apache-2.0
#include "server/observe/frame_trace.hpp"

#include "gtest/gtest.h"
#include "proto/wire/traceparent.hpp"

namespace segserve::server {
namespace {

constexpr const char* kSampled = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
constexpr const char* kNotSampled = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-00";

TEST(FrameTrace, GoesOnWithThatOfTheClient) {
  const FrameTrace trace = trace_of(kSampled, 0.0);
  EXPECT_EQ(trace.trace_id, "4bf92f3577b34da6a3ce929d0e0e4736");
  EXPECT_EQ(trace.parent_id, "00f067aa0ba902b7");
  EXPECT_TRUE(wire::parse_traceparent("00-" + trace.trace_id + "-" + trace.span_id + "-00"));
  EXPECT_NE(trace.span_id, trace_of(kSampled, 0.0).span_id);
}

TEST(FrameTrace, IsRecordedAsTheClientWants) { EXPECT_EQ(trace_of(kNotSampled, 1.0).span_id, ""); }

TEST(FrameTrace, IsNamedInLogsWithoutARecord) {
  for (const char* text : {kSampled, kNotSampled}) {
    const FrameTrace trace = trace_of(text, std::nullopt);
    EXPECT_EQ(trace.trace_id, "4bf92f3577b34da6a3ce929d0e0e4736");
    EXPECT_EQ(trace.span_id, "");
  }
}

TEST(FrameTrace, DoesNotExistWithoutClientOrRecord) {
  EXPECT_EQ(trace_of("", std::nullopt).trace_id, "");
  EXPECT_EQ(trace_of("", 0.0).trace_id, "");
  EXPECT_EQ(trace_of("no traceparent", std::nullopt).trace_id, "");
}

TEST(FrameTrace, BeginsForAShareOfTheOtherFrames) {
  for (const double share : {0.0, 0.25, 1.0}) {
    int recorded = 0;
    constexpr int kFrames = 4000;
    for (int i = 0; i < kFrames; ++i) {
      const FrameTrace trace = trace_of(i % 2 == 0 ? "" : "no traceparent", share);
      EXPECT_EQ(trace.parent_id, "");
      EXPECT_EQ(trace.trace_id.empty(), trace.span_id.empty());
      if (!trace.span_id.empty()) ++recorded;
    }
    EXPECT_NEAR(recorded, share * kFrames, share == 0.25 ? 200 : 0);
  }
}

}  // namespace
}  // namespace segserve::server
