// SPDX-License-Identifier: Apache-2.0
// How a stream makes and gives up connections. The test is the clock, the transport and the servers.
#include "client/tls/handshake_fault.hpp"
#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "test/client/stream/stream_harness.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using Response = v1::SegmentStreamResponse;

TEST(StreamScheduler, ABrokenConnectionMovesItsFramesToTheNextAddress) {
  StreamHarness stream({.max_waiting = 3}, {"a", "b"});
  stream.act();
  ASSERT_EQ(stream.actions_.size(), 2U);
  EXPECT_EQ(stream.actions_[0].server.address, "a");
  EXPECT_EQ(stream.actions_[1].server.address, "b");
  stream.open_on(1);
  stream.send();
  stream.send();
  EXPECT_EQ(stream.begun_on(1), 2U);
  stream.scheduler_.on_closed(1, absl::CancelledError(""), stream.now_);  // a server that shuts down ends calls so
  stream.open_on(2);
  EXPECT_EQ(stream.begun_on(2), 2U);
  stream.end_on(2, 2);
  stream.end_on(2, 1);
  EXPECT_EQ(stream.taken().size(), 2U);
  EXPECT_EQ(stream.last_.report.attempts, 2U);
  EXPECT_EQ(stream.last_.report.address, "b");
}

TEST(StreamScheduler, WithOneAddressItWaitsBeforeItTriesAgain) {
  StreamHarness stream({}, {"a"});
  stream.open();
  stream.close(absl::UnavailableError("gone"));
  stream.act();
  EXPECT_EQ(stream.connections_.size(), 1U);
  stream.pass(RetryOptions{}.first_backoff);
  EXPECT_EQ(stream.connections_.size(), 2U);
}

TEST(StreamScheduler, ALongOutageEndsTheStream) {
  StreamHarness stream({.max_waiting = 3, .frame_timeout = milliseconds(60'000), .longest_outage = milliseconds(4000)},
                       {"a"});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.close(absl::UnavailableError("gone"));
  for (int i = 0; i < 3; ++i) stream.pass(milliseconds(1000));
  stream.open();  // that was short enough
  EXPECT_EQ(stream.begun(), 1U);
  stream.pass(milliseconds(1000));
  stream.close(absl::UnavailableError("gone again"));
  stream.act();
  stream.pass(milliseconds(3999));
  EXPECT_TRUE(stream.taken().empty());
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kOpen);
  stream.pass(milliseconds(1));
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsUnavailable(stream.last_.status));
  EXPECT_TRUE(is_outage(stream.last_.status));
  EXPECT_EQ(stream.last_.status.message(), "no server has been in reach for 4 s (gone again)");
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kRefused);
  EXPECT_TRUE(is_outage(stream.scheduler_.refusal()));
  EXPECT_TRUE(stream.scheduler_.exhausted());
}

TEST(StreamScheduler, AServerThatDrainsIsNoOutageWhileItComputes) {
  StreamHarness stream({.frame_timeout = milliseconds(60'000), .longest_outage = milliseconds(4000)}, {"a"});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  const auto old = stream.connections_.back();
  Response draining;
  draining.mutable_draining();
  stream.answer(draining);
  for (int i = 0; i < 20; ++i) {
    stream.pass(milliseconds(1000));
    if (stream.connections_.back() != old) stream.close(absl::UnavailableError("not yet"));
    stream.scheduler_.on_sign_of_life(old, stream.now_);
  }
  stream.answer(StreamHarness::outcome(1, v1::OUTCOME_KIND_RESULT), old);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  stream.pass(milliseconds(3000));
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kOpen);
}

TEST(StreamScheduler, WithoutALimitAnOutageMayLast) {
  StreamHarness stream({.frame_timeout = milliseconds(86'400'000)}, {"a"});
  stream.send();
  for (int hours = 0; hours < 20; ++hours) {
    stream.pass(std::chrono::hours(1));
    stream.close(absl::UnavailableError("gone"));
  }
  EXPECT_TRUE(stream.taken().empty());
}

TEST(StreamScheduler, AHandshakeThatFailsIsFinalOnceEveryAddressHasFailed) {
  HandshakeReport report{.end = HandshakeReport::End::kNotTls};
  const absl::Status fault = fault_of(report, "a", {"a", "1"}, ClientTls{}, {});
  ASSERT_TRUE(absl::IsUnauthenticated(fault));
  StreamHarness stream({}, {"a", "b"});
  stream.send();
  stream.act();
  ASSERT_EQ(stream.connections_.size(), 2U);
  stream.scheduler_.on_closed(1, fault, stream.now_);
  EXPECT_TRUE(stream.taken().empty()) << "the other address may do";
  stream.scheduler_.on_closed(2, fault, stream.now_);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_EQ(stream.last_.status, fault);
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kRefused);
}

TEST(StreamScheduler, ADrainingServerKeepsWhatItHasAndGetsNothingNew) {
  StreamHarness stream({.max_waiting = 5});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  const auto old = stream.connections_.back();
  Response draining;
  draining.mutable_draining();
  stream.answer(draining);
  stream.send();
  EXPECT_TRUE(StreamHarness::headers(stream.sent(old)).empty());
  EXPECT_TRUE(stream.scheduler_.wants_half_close(old));
  stream.pass(RetryOptions{}.first_backoff);
  stream.open();
  EXPECT_NE(stream.connections_.back(), old);
  EXPECT_EQ(stream.begun(), 1U);
  stream.answer(StreamHarness::outcome(1, v1::OUTCOME_KIND_RESULT), old);
  stream.scheduler_.on_closed(old, absl::UnavailableError("drained"), stream.now_);
  stream.end(1);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult), ended(2, OutcomeKind::kResult)));
  EXPECT_EQ(stream.last_.report.attempts, 1U);
}

Response old_stream() {
  Response response;
  response.mutable_draining()->set_reason(v1::DRAIN_REASON_STREAM_AGE);
  return response;
}

TEST(StreamScheduler, AnOldConnectionTakesFramesUntilThereIsAnother) {
  StreamHarness stream({.max_waiting = 5});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  const auto old = stream.connections_.back();
  stream.answer(old_stream());
  stream.act();
  ASSERT_EQ(stream.actions_.size(), 3U);
  EXPECT_EQ(stream.actions_[1].kind, LinkAction::kRenew);
  EXPECT_EQ(stream.actions_[1].connection, old);
  EXPECT_EQ(stream.actions_[2].kind, LinkAction::kOpen);
  stream.send();
  EXPECT_EQ(StreamHarness::headers(stream.sent(old)).size(), 1U) << "nothing waits for the new connection";
  EXPECT_FALSE(stream.scheduler_.wants_half_close(old));

  stream.open();
  stream.send();
  EXPECT_TRUE(StreamHarness::headers(stream.sent(old)).empty());
  EXPECT_TRUE(stream.scheduler_.wants_half_close(old));
  EXPECT_EQ(stream.begun(), 1U);
  stream.answer(StreamHarness::outcome(1, v1::OUTCOME_KIND_RESULT), old);
  stream.answer(StreamHarness::outcome(2, v1::OUTCOME_KIND_RESULT), old);
  stream.scheduler_.on_closed(old, absl::OkStatus(), stream.now_);
  stream.end(1);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult), ended(2, OutcomeKind::kResult),
                                          ended(3, OutcomeKind::kResult)));
  EXPECT_EQ(stream.last_.report.attempts, 1U);
}

TEST(StreamScheduler, AnOldConnectionServesWhileNoOtherCanBeMade) {
  StreamHarness stream({.max_waiting = 5, .wait_for_server = false}, {"a"});
  stream.open();
  const auto old = stream.connections_.back();
  stream.answer(old_stream());
  stream.act();
  ASSERT_NE(stream.connections_.back(), old);
  stream.close(absl::UnavailableError("no more connections"));
  stream.send();
  stream.act();
  EXPECT_TRUE(stream.taken().empty()) << "the old connection is in reach";
  EXPECT_EQ(StreamHarness::headers(stream.sent(old)).size(), 1U);
  stream.answer(StreamHarness::outcome(1, v1::OUTCOME_KIND_RESULT), old);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  stream.pass(milliseconds(1000));
  EXPECT_EQ(stream.connections_.size(), 3U) << "it tries again";
}

TEST(StreamScheduler, AnOldConnectionOfAServerThatStopsIsLeft) {
  StreamHarness stream({.max_waiting = 5});
  stream.open();
  const auto old = stream.connections_.back();
  stream.answer(old_stream());
  Response draining;
  draining.mutable_draining();
  stream.answer(draining);
  stream.send();
  EXPECT_TRUE(StreamHarness::headers(stream.sent(old)).empty());
  EXPECT_TRUE(stream.scheduler_.wants_half_close(old));
  stream.pass(RetryOptions{}.first_backoff);
  stream.open();
  EXPECT_EQ(stream.begun(), 1U);
}

/// The server no longer accepts the token of the stream.
Response token_is_over() {
  Response response;
  response.mutable_draining()->set_reason(v1::DRAIN_REASON_TOKEN);
  return response;
}

/// The frame fails because of that.
Response refused_token(std::uint64_t number) {
  Response response = StreamHarness::outcome(number, v1::OUTCOME_KIND_FAILED);
  *response.mutable_outcome()->mutable_status() = wire::to_message(absl::UnauthenticatedError("the token is over"));
  return response;
}

TEST(StreamScheduler, AFrameAfterTheEndOfATokenGoesToAStreamWithTheNextToken) {
  StreamHarness stream({.wait_for_server = false}, {"a"});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  const auto old = stream.connections_.back();
  stream.answer(token_is_over());
  stream.answer(refused_token(1));
  stream.scheduler_.on_closed(old, absl::UnauthenticatedError("the token is over"), stream.now_);
  stream.open();
  EXPECT_NE(stream.connections_.back(), old) << "the same server is asked at once";
  EXPECT_TRUE(stream.taken().empty());
  EXPECT_EQ(stream.begun(), 1U);
  stream.end(1);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
}

TEST(StreamScheduler, AStreamWithoutAGoodTokenFailsAtOnce) {
  StreamHarness stream;
  stream.act();
  stream.send();
  stream.close(absl::UnauthenticatedError("no token"));
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsUnauthenticated(stream.scheduler_.refusal()));
}

TEST(StreamScheduler, ARejectedFrameFailsIfThatWasAskedFor) {
  StreamHarness stream({.when_behind = WhenBehind::kReject});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.fail(1, absl::ResourceExhaustedError("full"));
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
}

TEST(StreamScheduler, ObeysTheServersRetryInfo) {
  StreamHarness stream;
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  wire::ErrorDetails details;
  details.reason = wire::ErrorReason::kQueueFull;
  details.retry_delay = milliseconds(3000);
  stream.fail(1, wire::with_details(absl::ResourceExhaustedError("full"), details));
  stream.pass(milliseconds(2990));
  EXPECT_EQ(stream.begun(), 0U);
  stream.pass(milliseconds(10));
  EXPECT_EQ(stream.begun(), 1U);
}

TEST(StreamScheduler, AFrameThatBreaksEveryConnectionIsGivenUp) {
  StreamHarness stream({.retry = {.max_attempts = 3}});
  stream.send();
  for (int i = 0; i < 3; ++i) {
    stream.pass(milliseconds(10'000 / 4));
    stream.open();
    EXPECT_EQ(stream.begun(), 1U);
    stream.close(absl::UnavailableError("crashed"));
  }
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsUnavailable(stream.last_.status)) << stream.last_.status;
}

TEST(StreamScheduler, AfterTheDeadlineTheServersAnswerCountsNoMore) {
  StreamHarness stream;
  stream.open();
  stream.send({.timeout = milliseconds(100)});
  EXPECT_EQ(stream.begun(), 1U);
  stream.pass(milliseconds(100));
  const auto messages = stream.sent();
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages[0].has_cancel());
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_TRUE(absl::IsDeadlineExceeded(stream.last_.status));
  stream.end(1);
  EXPECT_TRUE(stream.taken().empty());
}

TEST(StreamScheduler, ASilentConnectionIsProbedAndThenGivenUp) {
  StreamHarness stream({.progress_timeout = milliseconds(1000)});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.pass(milliseconds(500));
  EXPECT_EQ(stream.actions_.back().kind, LinkAction::kProbe);
  stream.scheduler_.on_probe_answered(stream.connections_.back(), stream.now_);
  stream.pass(milliseconds(500));
  EXPECT_EQ(stream.actions_.back().kind, LinkAction::kProbe);
  stream.pass(milliseconds(500));
  ASSERT_EQ(stream.actions_.size(), 4U);
  EXPECT_EQ(stream.actions_[3].kind, LinkAction::kBreakSilent);
  stream.pass(RetryOptions{}.first_backoff);
  ASSERT_EQ(stream.actions_.size(), 5U);
  EXPECT_EQ(stream.actions_[4].kind, LinkAction::kOpen);
}

TEST(StreamScheduler, AStreamThatDoesNotOpenThoughAProbeIsAnsweredLeadsToAnotherServer) {
  StreamHarness stream;
  stream.act();
  stream.pass(milliseconds(500));
  ASSERT_EQ(stream.actions_.size(), 2U);
  EXPECT_EQ(stream.actions_[1].kind, LinkAction::kProbe);
  stream.scheduler_.on_probe_answered(stream.connections_.back(), stream.now_);
  stream.pass(milliseconds(499));
  EXPECT_EQ(stream.actions_.size(), 2U);
  stream.pass(milliseconds(1));
  ASSERT_EQ(stream.actions_.size(), 3U);
  EXPECT_EQ(stream.actions_[2].kind, LinkAction::kBreak);
  stream.pass(RetryOptions{}.first_backoff);
  ASSERT_EQ(stream.actions_.size(), 4U);
  EXPECT_EQ(stream.actions_[3].kind, LinkAction::kOpen);
}

TEST(StreamScheduler, AStreamThatOpensRightAfterItsProbeStays) {
  StreamHarness stream;
  stream.act();
  stream.pass(milliseconds(500));
  stream.scheduler_.on_probe_answered(stream.connections_.back(), stream.now_);
  stream.pass(milliseconds(400));
  stream.open_on(stream.connections_.back());
  stream.pass(milliseconds(60'000));
  EXPECT_EQ(stream.actions_.size(), 2U);
}

TEST(StreamScheduler, AnIdleConnectionOwesNothing) {
  StreamHarness stream({.progress_timeout = milliseconds(1000)});
  stream.open();
  stream.pass(milliseconds(60'000));
  EXPECT_EQ(stream.actions_.size(), 1U);
}

TEST(StreamScheduler, AnErrorThatEveryServerWouldRepeatEndsTheStream) {
  StreamHarness stream;
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.close(absl::InvalidArgumentError("options.lambda: 7"));
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kRefused);
  EXPECT_TRUE(absl::IsInvalidArgument(stream.scheduler_.refusal()));
  EXPECT_TRUE(stream.scheduler_.exhausted());
  stream.act();
  EXPECT_EQ(stream.connections_.size(), 1U);
}

TEST(StreamScheduler, LocalWorkNeedsEveryAddressToHaveFailed) {
  StreamHarness stream({.fallback_to_local = true}, {"a", "b"});
  stream.send();
  stream.act();
  EXPECT_FALSE(stream.scheduler_.take_local_job(stream.now_).has_value());
  stream.scheduler_.on_closed(1, absl::UnavailableError("gone"), stream.now_);
  stream.act();
  EXPECT_FALSE(stream.scheduler_.take_local_job(stream.now_).has_value());
  stream.scheduler_.on_closed(2, absl::UnavailableError("gone"), stream.now_);
  const auto job = stream.scheduler_.take_local_job(stream.now_);
  ASSERT_TRUE(job.has_value());
  EXPECT_FALSE(stream.scheduler_.take_local_job(stream.now_).has_value());
  stream.scheduler_.on_local_result(job->sequence, Result{}, stream.now_);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  EXPECT_TRUE(stream.last_.report.local);
}

TEST(StreamScheduler, ALocalJobHasTheFramesOutputsOrElseTheStreams) {
  StreamHarness stream({.outputs = {.labels = true, .segments = true}, .max_waiting = 2, .fallback_to_local = true},
                       {"a"});
  stream.send();
  stream.send({.options = Options{.lambda = 0.25}, .outputs = wire::Outputs{.labels = false, .tree = true}});
  stream.act();
  stream.close(absl::UnavailableError("gone"));
  const auto of_stream = stream.scheduler_.take_local_job(stream.now_);
  const auto of_frame = stream.scheduler_.take_local_job(stream.now_);
  ASSERT_TRUE(of_stream && of_frame);
  EXPECT_EQ(of_stream->outputs, (wire::Outputs{.labels = true, .segments = true}));
  EXPECT_EQ(of_stream->options, Options{});
  EXPECT_EQ(of_frame->outputs, (wire::Outputs{.labels = false, .tree = true}));
  EXPECT_EQ(of_frame->options, Options{.lambda = 0.25});
}

TEST(StreamScheduler, TheLastOutcomeHalfClosesAndNothingIsReopened) {
  StreamHarness stream;
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.scheduler_.finish_sending();
  stream.act();
  EXPECT_FALSE(stream.scheduler_.wants_half_close(stream.connections_.back()));
  stream.end(1);
  stream.act();
  EXPECT_TRUE(stream.scheduler_.wants_half_close(stream.connections_.back()));
  EXPECT_FALSE(stream.scheduler_.exhausted());
  EXPECT_EQ(stream.taken().size(), 1U);
  EXPECT_TRUE(stream.scheduler_.exhausted());
  stream.close(absl::OkStatus());
  stream.pass(milliseconds(10'000));
  EXPECT_EQ(stream.connections_.size(), 1U);
}

}  // namespace
}  // namespace segserve::client
