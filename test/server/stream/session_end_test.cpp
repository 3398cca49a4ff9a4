// SPDX-License-Identifier: Apache-2.0
// Tests how a stream ends. Clock and workers are in the test's hands.
#include <chrono>

#include "gtest/gtest.h"
#include "test/server/support/session_harness.hpp"

namespace segserve::server {
namespace {

TEST(Session, HalfCloseEndsItWhenEveryFrameHasItsOutcome) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(1));
  harness.session->on_half_close();
  EXPECT_FALSE(harness.session->ended());
  harness.compute();
  EXPECT_FALSE(harness.session->ended()) << "the result is not sent yet";
  harness.read();
  EXPECT_EQ(harness.session->ended(), absl::OkStatus());
}

TEST(Session, HalfCloseInTheMiddleOfAFrameFailsIt) {
  SessionHarness harness;
  harness.open();
  harness.say_header(SentFrame(1).header);
  harness.session->on_half_close();
  harness.session->on_tick();
  EXPECT_TRUE(harness.read().empty()) << "the client may have vanished";
  harness.now += std::chrono::milliseconds(100);
  harness.session->on_tick();
  EXPECT_EQ(reason_of(harness.outcome()), wire::ErrorReason::kMalformedPayload);
  EXPECT_EQ(harness.session->ended(), absl::OkStatus());
}

TEST(Session, DrainingLetsFramesFinishAndRefusesLaterOnes) {
  SessionHarness harness;
  harness.open();
  SentFrame begun(1);
  harness.say_header(begun.header);
  harness.session->start_draining();
  const auto said = harness.read();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_TRUE(said[0].has_draining());
  while (!begun.bytes.done()) harness.say_chunk(1, begun.bytes.next());
  harness.send(SentFrame(2));
  harness.compute();
  const auto outcomes = harness.outcomes();
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[0].kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(reason_of(outcomes[1]), wire::ErrorReason::kDraining);
  const auto ended = harness.session->ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(wire::details_of(*ended).retry_delay);
}

TEST(Session, DrainingDoesNotInterruptTheBytesOfAResult) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(1));
  harness.compute();
  SessionHarness::Response response;
  ASSERT_TRUE(harness.session->next(response));
  ASSERT_GT(response.outcome().encoded_bytes(), 0U);
  harness.session->start_draining();
  const auto said = harness.read();
  ASSERT_EQ(said.size(), 2U);
  EXPECT_TRUE(said[0].has_chunk());
  EXPECT_TRUE(said[1].has_draining());
}

TEST(Session, AnOldStreamIsAskedToMoveAndTakesFramesForAGrace) {
  using namespace std::chrono_literals;
  SessionHarness harness;
  harness.settings.max_age = 60s;
  harness.settings.age_grace = 20s;
  const auto born = harness.now;
  harness.open();
  const auto pass_to = [&](std::chrono::seconds age) {
    harness.now = born + age;
    harness.session->on_tick();
  };
  pass_to(54s - 1s);
  EXPECT_TRUE(harness.read().empty());
  pass_to(66s);
  auto said = harness.read();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].draining().reason(), v1::DRAIN_REASON_STREAM_AGE);
  pass_to(66s);
  EXPECT_TRUE(harness.read().empty()) << "it is asked once";
  EXPECT_FALSE(harness.session->ended());

  harness.send(SentFrame(1));
  pass_to(87s);  // the grace is over
  harness.send(SentFrame(2));
  ASSERT_EQ(harness.executor.queued(), 1U);
  harness.compute();
  const auto outcomes = harness.outcomes();
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[0].kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(reason_of(outcomes[1]), wire::ErrorReason::kDraining);
  const auto ended = harness.session->ended();
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(wire::details_of(*ended).reason, wire::ErrorReason::kDraining);
}

TEST(Session, AnOldStreamHearsThatTheServerStops) {
  SessionHarness harness;
  harness.settings.max_age = std::chrono::seconds(60);
  harness.open();
  harness.send(SentFrame(1));
  harness.now += std::chrono::seconds(67);
  harness.session->on_tick();
  harness.session->start_draining();
  const auto said = harness.read();
  ASSERT_EQ(said.size(), 1U);
  EXPECT_EQ(said[0].draining().reason(), v1::DRAIN_REASON_UNSPECIFIED);
}

TEST(Session, AnIdleStreamEndsAtOnceWhenTheServerDrains) {
  SessionHarness harness;
  harness.open();
  harness.session->start_draining();
  harness.read();
  EXPECT_EQ(harness.session->ended()->code(), absl::StatusCode::kUnavailable);
}

TEST(Session, ABrokenConnectionStopsTheComputationAndWaitsForIt) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(1));
  harness.send(SentFrame(2));
  harness.on_segment = [&](const CloudView&, const Options&, const StopToken& stop) -> absl::StatusOr<Segmentation> {
    harness.session->on_cancel(absl::CancelledError("gone"));
    EXPECT_FALSE(harness.session->ended()) << "a worker is still at it";
    return stop.check();
  };
  harness.compute();
  EXPECT_EQ(harness.executor.queued(), 0U);
  EXPECT_EQ(harness.session->ended()->code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(harness.read().empty());
}

TEST(Session, AWorkerThatTookAFrameOfAnEndedStreamLetsItBe) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(1));
  FrameJob job = harness.executor.take();
  harness.session->on_cancel(absl::CancelledError("gone"));
  harness.on_segment = [](const CloudView&, const auto&, const auto&) -> absl::StatusOr<Segmentation> {
    ADD_FAILURE() << "segmented in vain";
    return absl::InternalError("");
  };
  job.run(harness.backend());
  EXPECT_TRUE(harness.session->ended());
}

TEST(Session, AMessageThatCannotBeParsedEndsTheStream) {
  SessionHarness harness;
  harness.open();
  harness.session->on_broken_message(wire::malformed("the message is no serialized SegmentStreamRequest"));
  ASSERT_TRUE(harness.session->ended());
  EXPECT_EQ(wire::details_of(*harness.session->ended()).reason, wire::ErrorReason::kProtocolViolation);
}

TEST(Session, AStreamThatDoesNothingEnds) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(1));
  harness.now += harness.settings.idle_timeout;
  harness.session->on_tick();
  EXPECT_FALSE(harness.session->ended()) << "a frame is in flight";
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT);
  harness.now += harness.settings.idle_timeout - std::chrono::milliseconds(1);
  harness.session->on_tick();
  EXPECT_FALSE(harness.session->ended());
  harness.now += std::chrono::milliseconds(1);
  harness.session->on_tick();
  ASSERT_TRUE(harness.session->ended());
  EXPECT_TRUE(absl::IsUnavailable(*harness.session->ended())) << *harness.session->ended();
}

TEST(Session, AnUploadOfAByteNowAndThenIsStalled) {
  SessionHarness harness;
  harness.open();
  const SentFrame frame(1);
  harness.say_header(frame.header);
  const auto step = harness.settings.upload_timeout / 2;
  for (auto passed = step; passed < harness.settings.upload_grace; passed += step) {
    harness.now += step;
    harness.say_chunk(1, "x");
    harness.session->on_tick();
    EXPECT_TRUE(harness.outcomes().empty()) << passed.count();
  }
  harness.now += step + std::chrono::seconds(1);
  harness.session->on_tick();
  const v1::FrameOutcome outcome = harness.outcome();
  EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_FAILED);
  EXPECT_EQ(wire::details_of(wire::from_message(outcome.status())).reason, wire::ErrorReason::kUploadStalled);
}

TEST(Session, AFrameHoldsMemoryFromItsHeaderUntilItsResultIsRead) {
  SessionHarness harness;
  harness.open();
  EXPECT_EQ(harness.ledger.leased(), 0U) << "credit alone holds none";
  SentFrame frame(1);
  const std::uint64_t payload = frame.header.encoded_bytes();
  harness.send(std::move(frame));
  EXPECT_EQ(harness.ledger.leased(), payload);
  harness.compute();
  EXPECT_GT(harness.ledger.leased(), 0U);
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT);
  EXPECT_EQ(harness.ledger.leased(), 0U);
}

TEST(Session, AFrameThatFindsNoMemoryIsToBeSentAgain) {
  SessionHarness harness;
  harness.open();
  auto others = harness.ledger.lease({"elsewhere", "others"}, SessionHarness::kMemory - 8);
  harness.send(SentFrame(1));
  const v1::FrameOutcome outcome = harness.outcome();
  EXPECT_EQ(outcome.kind(), v1::OUTCOME_KIND_FAILED);
  const wire::ErrorDetails details = wire::details_of(wire::from_message(outcome.status()));
  EXPECT_EQ(details.reason, wire::ErrorReason::kQueueFull);
  EXPECT_TRUE(details.retry_delay);
  others->release();
  harness.send(SentFrame(2));
  harness.compute();
  EXPECT_EQ(harness.outcome().kind(), v1::OUTCOME_KIND_RESULT);
}

TEST(Session, TheEndOfAStreamFreesItsMemory) {
  SessionHarness harness;
  harness.open();
  harness.send(SentFrame(1));
  harness.send(SentFrame(2));
  harness.compute();
  EXPECT_GT(harness.ledger.leased(), 0U);
  harness.session->on_cancel(absl::CancelledError("gone"));
  EXPECT_EQ(harness.ledger.leased(), 0U);
}

}  // namespace
}  // namespace segserve::server
