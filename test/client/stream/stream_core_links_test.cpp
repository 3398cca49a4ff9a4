// What a stream decides about connections, without transport: the test is the clock and the server.
#include "gmock/gmock.h"
#include "test/client/stream/stream_core_bench.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using Response = v1::SegmentStreamResponse;

TEST(StreamCore, ABrokenConnectionMovesItsFramesToTheNextAddress) {
  Bench bench({.max_waiting = 3});
  bench.open();
  bench.send();
  bench.send();
  EXPECT_EQ(bench.begun(), 2U);
  bench.close(absl::CancelledError(""));  // as a server that shuts down does
  bench.open();
  ASSERT_EQ(bench.actions_.size(), 2U);
  EXPECT_EQ(bench.actions_[0].address, 0U);
  EXPECT_EQ(bench.actions_[1].address, 1U);
  EXPECT_EQ(bench.begun(), 2U);
  bench.end(2);
  bench.end(1);
  EXPECT_EQ(bench.taken().size(), 2U);
  EXPECT_EQ(bench.last_.report.attempts, 2U);
  EXPECT_EQ(bench.last_.report.address, "b");
}

TEST(StreamCore, WithOneAddressItWaitsBeforeItTriesAgain) {
  Bench bench({}, {"a"});
  bench.open();
  bench.close(absl::UnavailableError("gone"));
  bench.act();
  EXPECT_EQ(bench.connections_.size(), 1U);
  bench.pass(RetryOptions{}.first_backoff);
  EXPECT_EQ(bench.connections_.size(), 2U);
}

TEST(StreamCore, ADrainingServerKeepsWhatItHasAndGetsNothingNew) {
  Bench bench({.max_waiting = 5});
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  const auto old = bench.connections_.back();
  Response draining;
  draining.mutable_draining();
  bench.answer(draining);
  bench.send();
  EXPECT_TRUE(Bench::headers(bench.sent(old)).empty());
  EXPECT_TRUE(bench.core_.wants_half_close(old));
  bench.open();
  EXPECT_NE(bench.connections_.back(), old);
  EXPECT_EQ(bench.begun(), 1U);
  bench.answer(Bench::outcome(1, v1::OUTCOME_KIND_RESULT), old);
  bench.core_.on_closed(old, absl::UnavailableError("drained"), bench.now_);
  bench.end(1);
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kResult), ended(2, OutcomeKind::kResult)));
  EXPECT_EQ(bench.last_.report.attempts, 1U);
}

TEST(StreamCore, ARejectedFrameFailsIfThatWasAskedFor) {
  Bench bench({.when_behind = WhenBehind::kReject});
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.fail(1, absl::ResourceExhaustedError("full"));
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
}

TEST(StreamCore, ObeysTheServersRetryInfo) {
  Bench bench;
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  wire::ErrorDetails details;
  details.reason = v1::ERROR_REASON_QUEUE_FULL;
  details.retry_delay = milliseconds(3000);
  bench.fail(1, wire::with_details(absl::ResourceExhaustedError("full"), details));
  bench.pass(milliseconds(2990));
  EXPECT_EQ(bench.begun(), 0U);
  bench.pass(milliseconds(10));
  EXPECT_EQ(bench.begun(), 1U);
}

TEST(StreamCore, AFrameThatBreaksEveryConnectionIsGivenUp) {
  Bench bench({.retry = {.max_attempts = 3}});
  bench.send();
  for (int i = 0; i < 3; ++i) {
    bench.pass(milliseconds(10'000 / 4));
    bench.open();
    EXPECT_EQ(bench.begun(), 1U);
    bench.close(absl::UnavailableError("crashed"));
  }
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsUnavailable(bench.last_.status)) << bench.last_.status;
}

TEST(StreamCore, AfterTheDeadlineTheServersAnswerCountsNoMore) {
  Bench bench;
  bench.open();
  bench.send({.timeout = milliseconds(100)});
  EXPECT_EQ(bench.begun(), 1U);
  bench.pass(milliseconds(100));
  const auto messages = bench.sent();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages[0].has_cancel());
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsDeadlineExceeded(bench.last_.status));
  bench.end(1);
  EXPECT_TRUE(bench.taken().empty());
}

TEST(StreamCore, ASilentConnectionIsProbedAndThenGivenUp) {
  Bench bench({.progress_timeout = milliseconds(1000)});
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.pass(milliseconds(500));
  EXPECT_EQ(bench.actions_.back().kind, StreamCore::Action::kProbe);
  bench.core_.on_sign_of_life(bench.connections_.back(), bench.now_);
  bench.pass(milliseconds(500));
  EXPECT_EQ(bench.actions_.back().kind, StreamCore::Action::kProbe);
  bench.pass(milliseconds(500));
  ASSERT_EQ(bench.actions_.size(), 5U);
  EXPECT_EQ(bench.actions_[3].kind, StreamCore::Action::kBreakSilent);
  EXPECT_EQ(bench.actions_[4].kind, StreamCore::Action::kOpen);
  EXPECT_EQ(bench.actions_[4].address, 1U);
}

TEST(StreamCore, AnIdleConnectionOwesNothing) {
  Bench bench({.progress_timeout = milliseconds(1000)});
  bench.open();
  bench.pass(milliseconds(60'000));
  EXPECT_EQ(bench.actions_.size(), 1U);
}

TEST(StreamCore, AnErrorThatEveryServerWouldRepeatEndsTheStream) {
  Bench bench;
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.close(absl::InvalidArgumentError("options.lambda: 7"));
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_EQ(bench.core_.admission(), StreamCore::Admission::kRefused);
  EXPECT_TRUE(bench.core_.exhausted());
  bench.act();
  EXPECT_EQ(bench.connections_.size(), 1U);
}

TEST(StreamCore, LocalWorkNeedsEveryAddressToHaveFailed) {
  Bench bench({.fallback_to_local = true});
  bench.send();
  bench.act();
  EXPECT_FALSE(bench.core_.take_local_job(bench.now_).has_value());
  bench.close(absl::UnavailableError("gone"));
  bench.act();
  EXPECT_FALSE(bench.core_.take_local_job(bench.now_).has_value());
  bench.close(absl::UnavailableError("gone"));
  const auto job = bench.core_.take_local_job(bench.now_);
  ASSERT_TRUE(job.has_value());
  EXPECT_FALSE(bench.core_.take_local_job(bench.now_).has_value());
  bench.core_.on_local_result(job->sequence, Result{}, bench.now_);
  EXPECT_THAT(bench.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  EXPECT_TRUE(bench.last_.report.local);
}

TEST(StreamCore, ALocalJobHasTheFramesOutputsOrElseTheStreams) {
  Bench bench({.outputs = {.labels = true, .segments = true}, .max_waiting = 2, .fallback_to_local = true}, {"a"});
  bench.send();
  bench.send({.options = Options{.lambda = 0.25}, .outputs = wire::Outputs{.labels = false, .tree = true}});
  bench.act();
  bench.close(absl::UnavailableError("gone"));
  const auto of_stream = bench.core_.take_local_job(bench.now_);
  const auto of_frame = bench.core_.take_local_job(bench.now_);
  ASSERT_TRUE(of_stream && of_frame);
  EXPECT_EQ(of_stream->outputs, (wire::Outputs{.labels = true, .segments = true}));
  EXPECT_EQ(of_stream->options, Options{});
  EXPECT_EQ(of_frame->outputs, (wire::Outputs{.labels = false, .tree = true}));
  EXPECT_EQ(of_frame->options, Options{.lambda = 0.25});
}

TEST(StreamCore, TheLastOutcomeHalfClosesAndNothingIsReopened) {
  Bench bench;
  bench.open();
  bench.send();
  EXPECT_EQ(bench.begun(), 1U);
  bench.core_.finish_sending();
  bench.act();
  EXPECT_FALSE(bench.core_.wants_half_close(bench.connections_.back()));
  bench.end(1);
  bench.act();
  EXPECT_TRUE(bench.core_.wants_half_close(bench.connections_.back()));
  EXPECT_FALSE(bench.core_.exhausted());
  EXPECT_EQ(bench.taken().size(), 1U);
  EXPECT_TRUE(bench.core_.exhausted());
  bench.close(absl::OkStatus());
  bench.pass(milliseconds(10'000));
  EXPECT_EQ(bench.connections_.size(), 1U);
}

}  // namespace
}  // namespace segserve::client
