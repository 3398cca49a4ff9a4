// SPDX-License-Identifier: Apache-2.0
// Tests how a stream ends. Clock and workers are in the test's hands.
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

TEST(Session, GivesItsCreditBackWhenItIsClosed) {
  SessionHarness harness({.frames = 1, .bytes = 1000});
  EXPECT_EQ(harness.budget().free_bytes(), 4000U);
  harness.open();
  EXPECT_EQ(harness.budget().free_bytes(), 3000U);
  harness.session->close();
  EXPECT_EQ(harness.budget().free_bytes(), 4000U);
}

TEST(Session, WithoutCreditLeftTheStreamIsRefused) {
  SessionHarness harness({.frames = 1, .bytes = 1000});
  const auto all = harness.budget().reserve({.frames = 1, .bytes = 1000});
  const auto more = harness.budget().reserve({}), most = harness.budget().reserve({}),
             rest = harness.budget().reserve({});
  ASSERT_TRUE(all && more && most && rest);
  v1::SegmentStreamRequest message;
  message.mutable_open();
  harness.say(message);
  EXPECT_EQ(harness.session->ended()->code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(wire::details_of(*harness.session->ended()).retry_delay);
}

}  // namespace
}  // namespace segserve::server
