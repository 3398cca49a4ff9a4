// SPDX-License-Identifier: Apache-2.0
// How a stream carries the state of tracks from frame to frame. The test is the clock, the transport and the servers.
#include "gmock/gmock.h"
#include "test/client/stream/stream_harness.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

StreamOptions with_tracking() {
  StreamOptions options{.max_in_flight = 4, .max_waiting = 10};
  options.tracking = TrackOptions{.keep_lost = 7};
  return options;
}

/// The headers that a connection sends now.
std::vector<v1::FrameHeader> headers_of(StreamHarness& stream, ConnectionId id) {
  std::vector<v1::FrameHeader> headers;
  for (const v1::SegmentStreamRequest& message : stream.sent(id)) {
    if (message.has_frame()) headers.push_back(message.frame());
  }
  return headers;
}
std::vector<v1::FrameHeader> headers_of(StreamHarness& stream) {
  return headers_of(stream, stream.connections_.back());
}

v1::SegmentStreamResponse result_with(std::uint64_t number, const std::string& state) {
  v1::SegmentStreamResponse response = StreamHarness::outcome(number, v1::OUTCOME_KIND_RESULT);
  response.mutable_outcome()->mutable_result()->mutable_tracking()->set_state(state);
  return response;
}

TEST(StreamTracking, SendsOneFrameAtATimeWithTheStateOfTheOneBefore) {
  StreamHarness stream(with_tracking());
  stream.open();
  for (int i = 0; i < 3; ++i) stream.send();
  const auto first = headers_of(stream);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].tracking().state(), "");
  EXPECT_EQ(first[0].tracking().keep_lost(), 7U);
  EXPECT_TRUE(headers_of(stream).empty());
  stream.answer(result_with(1, "after 1"));
  const auto second = headers_of(stream);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].tracking().state(), "after 1");
  stream.answer(result_with(2, "after 2"));
  EXPECT_EQ(headers_of(stream).at(0).tracking().state(), "after 2");
}

TEST(StreamTracking, GoesOnFromTheLastResultWhenAFrameEndsWithoutOne) {
  StreamHarness stream(with_tracking());
  stream.open();
  for (int i = 0; i < 4; ++i) stream.send();
  headers_of(stream);
  stream.answer(result_with(1, "after 1"));
  headers_of(stream);
  stream.fail(2, absl::InvalidArgumentError("a bad cloud"));
  EXPECT_EQ(headers_of(stream).at(0).tracking().state(), "after 1");
  stream.scheduler_.cancel(3, stream.now_);
  stream.sent();
  stream.end(3, v1::OUTCOME_KIND_CANCELLED);
  EXPECT_EQ(headers_of(stream).at(0).tracking().state(), "after 1");
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult), ended(2, OutcomeKind::kFailed),
                                          ended(3, OutcomeKind::kCancelled)));
}

TEST(StreamTracking, LetsNoFrameOvertakeOneThatIsSentAgain) {
  StreamHarness stream(with_tracking());
  stream.open();
  stream.send();
  stream.send({.priority = 5});
  headers_of(stream);
  stream.answer(result_with(1, "after 1"));
  EXPECT_EQ(headers_of(stream).size(), 1U);
  stream.send({.priority = 9});
  stream.fail(2, absl::UnavailableError("busy"));
  stream.act();
  EXPECT_TRUE(headers_of(stream).empty()) << "frame 2 waits before it is sent again, and frame 3 waits for it";
  stream.pass(milliseconds(200));
  const auto again = headers_of(stream);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].tracking().state(), "after 1");
  EXPECT_EQ(again[0].priority(), 5);
}

TEST(StreamTracking, TellsTheTimeAndThePoseOfEachFrame) {
  StreamHarness stream(with_tracking());
  stream.open();
  FrameOptions options;
  options.stamp = std::chrono::system_clock::time_point(milliseconds(1500));
  options.pose.emplace().translation = {1, 2, 3};
  stream.send(options);
  const auto header = headers_of(stream).at(0);
  EXPECT_DOUBLE_EQ(header.tracking().time(), 1.5);
  EXPECT_DOUBLE_EQ(header.tracking().pose().translation().z(), 3);
}

TEST(StreamTracking, TakesAStateThatTheCallerHandsOn) {
  StreamHarness stream({.max_waiting = 10});
  stream.open();
  FrameOptions options;
  options.tracking = wire::TrackRequest{.options = {}, .state = "mine"};
  stream.send(options);
  stream.send();
  const auto headers = headers_of(stream);
  ASSERT_EQ(headers.size(), 2U);
  EXPECT_EQ(headers[0].tracking().state(), "mine");
  EXPECT_FALSE(headers[1].has_tracking());
}

}  // namespace
}  // namespace segserve::client
