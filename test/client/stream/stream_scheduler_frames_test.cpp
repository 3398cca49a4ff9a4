// SPDX-License-Identifier: Apache-2.0
// How a stream schedules frames. The test is the clock, the transport and the servers.
#include "gmock/gmock.h"
#include "test/client/stream/stream_harness.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using Response = v1::SegmentStreamResponse;

TEST(StreamScheduler, OpensAtOnceAndSendsNothingBeforeTheServerAgrees) {
  StreamHarness stream;
  stream.act();
  ASSERT_EQ(stream.connections_.size(), 1U);
  stream.send();
  const auto before = stream.sent();
  ASSERT_EQ(before.size(), 1U);
  EXPECT_TRUE(before[0].has_open());
  stream.open();
  const auto after = stream.sent();
  ASSERT_EQ(after.size(), 5U);  // the header and the chunks of x, y, z and colors
  EXPECT_TRUE(after[0].has_frame());
  EXPECT_EQ(after[0].frame().encoded_bytes(), 1500U);
  EXPECT_TRUE(after[0].frame().cloud().planar().x().data().empty());
  EXPECT_EQ(after[0].frame().cloud().planar().x().encoded_bytes(), 400U);
  EXPECT_EQ(after[4].chunk().data().size(), 300U);
}

TEST(StreamScheduler, KeepsToTheServersCreditAndItsOwnWindow) {
  StreamHarness narrow({.max_in_flight = 2, .max_waiting = 10});
  narrow.open(4);
  for (int i = 0; i < 5; ++i) narrow.send();
  EXPECT_EQ(narrow.begun(), 2U);
  narrow.end(1);
  EXPECT_EQ(narrow.begun(), 0U);  // the result was not taken yet
  EXPECT_EQ(narrow.taken().size(), 1U);
  EXPECT_EQ(narrow.begun(), 1U);

  StreamHarness wide({.max_in_flight = 10, .max_waiting = 10});
  wide.open(3);
  for (int i = 0; i < 5; ++i) wide.send();
  EXPECT_EQ(wide.begun(), 3U);
  wide.end(1);
  EXPECT_EQ(wide.begun(), 1U);

  StreamHarness small({.max_in_flight = 10, .max_waiting = 10});
  small.open(10, 3200);  // enough for two frames of 1500 bytes
  for (int i = 0; i < 5; ++i) small.send();
  EXPECT_EQ(small.begun(), 2U);
  small.end(2);
  EXPECT_EQ(small.begun(), 1U);
}

TEST(StreamScheduler, BlockWaitsRejectRefusesDropOldestDrops) {
  StreamHarness block({.when_behind = WhenBehind::kBlock, .max_waiting = 2});
  block.send();
  EXPECT_EQ(block.scheduler_.admission(), StreamScheduler::Admission::kOpen);
  block.send();
  EXPECT_EQ(block.scheduler_.admission(), StreamScheduler::Admission::kWait);

  StreamHarness reject({.when_behind = WhenBehind::kReject, .max_waiting = 1});
  reject.send();
  EXPECT_EQ(reject.scheduler_.admission(), StreamScheduler::Admission::kRefused);
  EXPECT_TRUE(absl::IsResourceExhausted(reject.scheduler_.refusal()));
  reject.scheduler_.finish_sending();
  EXPECT_TRUE(absl::IsFailedPrecondition(reject.scheduler_.refusal()));

  StreamHarness drop({.when_behind = WhenBehind::kDropOldest, .max_waiting = 2});
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(drop.scheduler_.admission(), StreamScheduler::Admission::kOpen);
    drop.send();
  }
  EXPECT_THAT(drop.taken(), ElementsAre(ended(1, OutcomeKind::kDropped), ended(2, OutcomeKind::kDropped)));
}

TEST(StreamScheduler, FramesOnTheirWayAreNotDropped) {
  StreamHarness stream({.when_behind = WhenBehind::kDropOldest, .max_in_flight = 1, .max_waiting = 1});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.send();
  stream.send();
  stream.end(1);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult), ended(2, OutcomeKind::kDropped)));
}

TEST(StreamScheduler, OutcomesComeInTheOrderAskedFor) {
  StreamHarness sent({.order = Order::kSent, .max_waiting = 4});
  sent.open();
  for (int i = 0; i < 3; ++i) sent.send();
  EXPECT_EQ(sent.begun(), 3U);
  sent.end(3);
  sent.end(2);
  EXPECT_TRUE(sent.taken().empty());
  sent.end(1);
  EXPECT_EQ(sent.taken().size(), 3U);

  StreamHarness done({.order = Order::kDone, .max_waiting = 4});
  done.open();
  for (int i = 0; i < 3; ++i) done.send();
  EXPECT_EQ(done.begun(), 3U);
  done.end(3);
  EXPECT_THAT(done.taken(), ElementsAre(ended(3, OutcomeKind::kResult)));
}

TEST(StreamScheduler, ResultsThatCameEarlyDoNotShutOutTheOneTheyWaitFor) {
  StreamHarness stream({.order = Order::kSent, .max_in_flight = 2, .max_waiting = 4});
  stream.open();
  for (int i = 0; i < 3; ++i) stream.send();
  EXPECT_EQ(stream.begun(), 2U);
  stream.fail(1, absl::AbortedError("crc"));
  EXPECT_EQ(stream.begun(), 1U);  // frame 3 has number 3 on the wire, while frame 1 waits
  stream.end(2);
  stream.end(3);
  stream.pass(milliseconds(1000));
  EXPECT_EQ(stream.begun(), 1U);  // frame 1 has number 4
  stream.end(4);
  EXPECT_EQ(stream.taken().size(), 3U);
}

TEST(StreamScheduler, CountsTheBytesOfAllMessagesOfAnOutcome) {
  StreamHarness stream;
  stream.open();
  for (const std::size_t chunk : {400U, 1200U}) {
    const std::uint64_t number = stream.send();
    stream.sent();
    Response response = StreamHarness::outcome(number, v1::OUTCOME_KIND_RESULT);
    response.mutable_outcome()->set_encoded_bytes(1200);
    response.mutable_outcome()->set_crc32(wire::crc32(0, std::string(1200, 'x')));
    response.mutable_outcome()->mutable_result()->mutable_labels()->mutable_data()->set_encoded_bytes(1200);
    std::uint64_t bytes = response.ByteSizeLong();
    stream.answer(response);
    for (std::size_t sent = 0; sent < 1200; sent += chunk) {
      response.mutable_chunk()->set_sequence(number);
      response.mutable_chunk()->set_data(std::string(chunk, 'x'));
      bytes += response.ByteSizeLong();
      stream.answer(response);
    }
    ASSERT_EQ(stream.taken().size(), 1U);
    EXPECT_EQ(stream.last_.report.bytes_received, bytes);
  }
}

TEST(StreamScheduler, HigherPriorityGoesFirst) {
  StreamHarness stream({.order = Order::kDone, .max_in_flight = 1, .max_waiting = 4});
  stream.send({.priority = 0});
  stream.send({.priority = 5});
  stream.send({.priority = 5});
  stream.open();
  EXPECT_EQ(stream.begun(), 1U);
  stream.end(1);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(2, OutcomeKind::kResult)));
}

TEST(StreamScheduler, TheAgeCountsFromTheCapture) {
  StreamHarness stream({.max_waiting = 3});
  stream.send({.captured = stream.now_ - milliseconds(300), .time_to_live = milliseconds(1000)});
  stream.send({.captured = stream.now_ - milliseconds(900), .time_to_live = milliseconds(1000)});
  stream.pass(milliseconds(200));
  stream.open();
  const auto messages = stream.sent();
  ASSERT_EQ(StreamHarness::headers(messages).size(), 1U);
  EXPECT_EQ(messages[0].frame().age().nanos(), 500'000'000);
  EXPECT_EQ(messages[0].frame().time_to_live().seconds(), 1);
  stream.end(1, v1::OUTCOME_KIND_EXPIRED);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kExpired), ended(2, OutcomeKind::kExpired)));
}

TEST(StreamScheduler, TheTickSaysWhenItIsNeededNext) {
  StreamHarness stream({.max_waiting = 3});
  stream.open();
  stream.send({.timeout = milliseconds(700)});
  stream.send({.time_to_live = milliseconds(300)});
  EXPECT_EQ(stream.scheduler_.tick(stream.now_).wake_at, stream.now_ + milliseconds(300));
}

TEST(StreamScheduler, ACancelledFrameEndsOnce) {
  StreamHarness stream({.max_in_flight = 1, .max_waiting = 3});
  stream.open();
  stream.send();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.scheduler_.cancel(2, stream.now_);
  stream.scheduler_.cancel(1, stream.now_);
  stream.scheduler_.cancel(77, stream.now_);
  const auto messages = stream.sent();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].cancel().sequence(), 1U);
  stream.end(1, v1::OUTCOME_KIND_CANCELLED);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kCancelled), ended(2, OutcomeKind::kCancelled)));
  stream.scheduler_.cancel(1, stream.now_);
  EXPECT_TRUE(stream.taken().empty());
}

TEST(StreamScheduler, ACancelledFrameIsNotSentAgain) {
  StreamHarness stream;
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.scheduler_.cancel(1, stream.now_);
  stream.close(absl::UnavailableError("gone"));
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kCancelled)));
}

TEST(StreamScheduler, TheServerHearsTheDeadlineAsATimeToLive) {
  StreamHarness stream({.max_waiting = 10});
  stream.open();
  stream.send({.timeout = milliseconds(800)});
  stream.send({.time_to_live = milliseconds(300), .timeout = milliseconds(800)});
  stream.send({.time_to_live = milliseconds(900), .timeout = milliseconds(800)});
  std::vector<std::int32_t> milliseconds_to_live;
  for (const v1::SegmentStreamRequest& message : stream.sent()) {
    if (message.has_frame()) milliseconds_to_live.push_back(message.frame().time_to_live().nanos() / 1'000'000);
  }
  EXPECT_THAT(milliseconds_to_live, ElementsAre(800, 300, 800));
  for (const std::uint64_t number : {1, 2, 3}) stream.end(number, v1::OUTCOME_KIND_EXPIRED);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed), ended(2, OutcomeKind::kExpired),
                                          ended(3, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsDeadlineExceeded(stream.last_.status)) << stream.last_.status;
}

/// A stream whose window has room for two frames, and whose server has taken 500 ms for each so far.
class SlowServer : public testing::Test {
 protected:
  SlowServer() {
    stream_.open();
    for (int i = 0; i < 30; ++i) {
      stream_.send();
      stream_.sent();
      stream_.pass(milliseconds(500));
      stream_.end(static_cast<std::uint64_t>(i + 1));
      stream_.taken();
    }
  }

  StreamHarness stream_{{.order = Order::kDone, .max_in_flight = 2, .max_waiting = 10}};
};

TEST_F(SlowServer, AFrameThatWouldComeTooLateMakesWayForTheNext) {
  const FrameOptions one_second{.timeout = milliseconds(1000)};
  const std::uint64_t first = stream_.send(one_second);
  stream_.send(one_second);
  const std::uint64_t late = stream_.send(one_second);
  EXPECT_EQ(stream_.begun(), 2U);
  stream_.pass(milliseconds(600));
  const std::uint64_t fresh = stream_.send(one_second);
  stream_.end(31);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(first, OutcomeKind::kResult)));
  EXPECT_EQ(stream_.begun(), 1U);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(late, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsDeadlineExceeded(stream_.last_.status)) << stream_.last_.status;
  EXPECT_EQ(stream_.scheduler_.admission(), StreamScheduler::Admission::kOpen);
  stream_.end(33);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(fresh, OutcomeKind::kResult)));
}

TEST_F(SlowServer, ALateFrameIsTriedIfNoOtherWaits) {
  stream_.send({.timeout = milliseconds(5000)});
  const std::uint64_t hurried = stream_.send({.timeout = milliseconds(100)});
  EXPECT_EQ(stream_.begun(), 2U);
  stream_.end(32);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(hurried, OutcomeKind::kResult)));
}

}  // namespace
}  // namespace segserve::client
