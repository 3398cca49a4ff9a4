// What a stream decides about frames, without transport: the test is the clock and the server.
#include "gmock/gmock.h"
#include "test/client/stream/stream_core_bench.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using Response = v1::SegmentStreamResponse;

TEST(StreamCore, OpensAtOnceAndSendsNothingBeforeTheServerAgrees) {
  Bench bench;
  bench.act();
  ASSERT_EQ(bench.connections_.size(), 1U);
  bench.send();
  const auto before = bench.sent();
  ASSERT_EQ(before.size(), 1U);
  EXPECT_TRUE(before[0].has_open());
  bench.open();
  const auto after = bench.sent();
  ASSERT_EQ(after.size(), 5U);  // header, x, y, z, rgb
  EXPECT_TRUE(after[0].has_frame());
  EXPECT_EQ(after[0].frame().encoded_bytes(), 1500U);
  EXPECT_TRUE(after[0].frame().cloud().planar().x().data().empty());
  EXPECT_EQ(after[0].frame().cloud().planar().x().encoded_bytes(), 400U);
  EXPECT_EQ(after[4].chunk().data().size(), 300U);
}

TEST(StreamCore, KeepsToTheServersCreditAndItsOwnWindow) {
  Bench narrow({.max_in_flight = 2, .max_waiting = 10});
  narrow.open(4);
  for (int i = 0; i < 5; ++i) narrow.send();
  EXPECT_EQ(narrow.begun(), 2U);
  narrow.end(1);
  EXPECT_EQ(narrow.begun(), 0U);  // nobody took the result yet
  EXPECT_EQ(narrow.taken().size(), 1U);
  EXPECT_EQ(narrow.begun(), 1U);

  Bench wide({.max_in_flight = 10, .max_waiting = 10});
  wide.open(3);
  for (int i = 0; i < 5; ++i) wide.send();
  EXPECT_EQ(wide.begun(), 3U);
  wide.end(1);
  EXPECT_EQ(wide.begun(), 1U);

  Bench small({.max_in_flight = 10, .max_waiting = 10});
  small.open(10, 3200);  // two frames of 1500 bytes
  for (int i = 0; i < 5; ++i) small.send();
  EXPECT_EQ(small.begun(), 2U);
  small.end(2);
  EXPECT_EQ(small.begun(), 1U);
}

TEST(StreamCore, BlockWaitsRejectRefusesDropOldestDrops) {
  Bench block({.when_behind = WhenBehind::kBlock, .max_waiting = 2});
  block.send();
  EXPECT_EQ(block.core_.admission(), StreamCore::Admission::kOpen);
  block.send();
  EXPECT_EQ(block.core_.admission(), StreamCore::Admission::kWait);

  Bench reject({.when_behind = WhenBehind::kReject, .max_waiting = 1});
  reject.send();
  EXPECT_EQ(reject.core_.admission(), StreamCore::Admission::kRefused);

  Bench drop({.when_behind = WhenBehind::kDropOldest, .max_waiting = 2});
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(drop.core_.admission(), StreamCore::Admission::kOpen);
    drop.send();
  }
  EXPECT_THAT(drop.taken(), ElementsAre(ended(1, OutcomeKind::kDropped), ended(2, OutcomeKind::kDropped)));
}

TEST(StreamCore, FramesOnTheirWayAreNotDropped) {
  Bench bench({.when_behind = WhenBehind::kDropOldest, .max_in_flight = 1, .max_waiting = 1});
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.send();
  bench.send();
  bench.end(1);
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kResult), ended(2, OutcomeKind::kDropped)));
}

TEST(StreamCore, OutcomesComeInTheOrderAskedFor) {
  Bench sent({.order = Order::kSent, .max_waiting = 4});
  sent.open();
  for (int i = 0; i < 3; ++i) sent.send();
  EXPECT_EQ(sent.begun(), 3U);
  sent.end(3);
  sent.end(2);
  EXPECT_TRUE(sent.taken().empty());
  sent.end(1);
  EXPECT_EQ(sent.taken().size(), 3U);

  Bench done({.order = Order::kDone, .max_waiting = 4});
  done.open();
  for (int i = 0; i < 3; ++i) done.send();
  EXPECT_EQ(done.begun(), 3U);
  done.end(3);
  EXPECT_THAT(done.taken(), ElementsAre(ended(3, OutcomeKind::kResult)));
}

TEST(StreamCore, ResultsThatCameEarlyDoNotShutOutTheOneTheyWaitFor) {
  Bench bench({.order = Order::kSent, .max_in_flight = 2, .max_waiting = 4});
  bench.open();
  for (int i = 0; i < 3; ++i) bench.send();
  EXPECT_EQ(bench.begun(), 2U);
  bench.fail(1, absl::AbortedError("crc"));
  EXPECT_EQ(bench.begun(), 1U);  // frame 3, as number 3, while 1 waits
  bench.end(2);
  bench.end(3);
  bench.pass(milliseconds(1000));
  EXPECT_EQ(bench.begun(), 1U);  // frame 1 again
  bench.end(4);
  EXPECT_EQ(bench.taken().size(), 3U);
}

TEST(StreamCore, CountsTheBytesOfAllMessagesOfAnOutcome) {
  Bench bench;
  bench.open();
  for (const std::size_t chunk : {400U, 1200U}) {
    const std::uint64_t number = bench.send();
    bench.sent();
    Response response = Bench::outcome(number, v1::OUTCOME_KIND_RESULT);
    response.mutable_outcome()->set_encoded_bytes(1200);
    response.mutable_outcome()->set_crc32(wire::crc32(0, std::string(1200, 'x')));
    response.mutable_outcome()->mutable_result()->mutable_labels()->mutable_data()->set_encoded_bytes(1200);
    std::uint64_t bytes = response.ByteSizeLong();
    bench.answer(response);
    for (std::size_t sent = 0; sent < 1200; sent += chunk) {
      response.mutable_chunk()->set_sequence(number);
      response.mutable_chunk()->set_data(std::string(chunk, 'x'));
      bytes += response.ByteSizeLong();
      bench.answer(response);
    }
    ASSERT_EQ(bench.taken().size(), 1U);
    EXPECT_EQ(bench.last_.report.bytes_received, bytes);
  }
}

TEST(StreamCore, HigherPriorityGoesFirst) {
  Bench bench({.order = Order::kDone, .max_in_flight = 1, .max_waiting = 4});
  bench.send({.priority = 0});
  bench.send({.priority = 5});
  bench.send({.priority = 5});
  bench.open();
  EXPECT_EQ(bench.begun(), 1U);
  bench.end(1);
  EXPECT_THAT(bench.taken(), ElementsAre(ended(2, OutcomeKind::kResult)));
}

TEST(StreamCore, TheAgeCountsFromTheCapture) {
  Bench bench({.max_waiting = 3});
  bench.send({.captured = bench.now_ - milliseconds(300), .time_to_live = milliseconds(1000)});
  bench.send({.captured = bench.now_ - milliseconds(900), .time_to_live = milliseconds(1000)});
  bench.pass(milliseconds(200));
  bench.open();
  const auto messages = bench.sent();
  ASSERT_EQ(Bench::headers(messages).size(), 1U);
  EXPECT_EQ(messages[0].frame().age().nanos(), 500'000'000);
  EXPECT_EQ(messages[0].frame().time_to_live().seconds(), 1);
  bench.end(1, v1::OUTCOME_KIND_EXPIRED);
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kExpired), ended(2, OutcomeKind::kExpired)));
}

TEST(StreamCore, TheTickSaysWhenItIsNeededNext) {
  Bench bench({.max_waiting = 3});
  bench.open();
  bench.send({.timeout = milliseconds(700)});
  bench.send({.time_to_live = milliseconds(300)});
  EXPECT_EQ(bench.core_.tick(bench.now_).wake_at, bench.now_ + milliseconds(300));
}

TEST(StreamCore, ACancelledFrameEndsOnce) {
  Bench bench({.max_in_flight = 1, .max_waiting = 3});
  bench.open();
  bench.send();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.core_.cancel(2, bench.now_);
  bench.core_.cancel(1, bench.now_);
  bench.core_.cancel(77, bench.now_);
  const auto messages = bench.sent();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].cancel().sequence(), 1U);
  bench.end(1, v1::OUTCOME_KIND_CANCELLED);
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kCancelled), ended(2, OutcomeKind::kCancelled)));
  bench.core_.cancel(1, bench.now_);
  EXPECT_TRUE(bench.taken().empty());
}

TEST(StreamCore, ACancelledFrameIsNotSentAgain) {
  Bench bench;
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.core_.cancel(1, bench.now_);
  bench.close(absl::UnavailableError("gone"));
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kCancelled)));
}

}  // namespace
}  // namespace segserve::client
