// SPDX-License-Identifier: Apache-2.0
// How a stream uses several servers at the same time. The test is the clock, the transport and the servers.
#include <algorithm>

#include "gmock/gmock.h"
#include "test/client/stream/stream_harness.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;

const std::vector<std::string> kThree{"a", "b", "c"};

std::size_t count_of(const StreamHarness& stream, LinkAction::Kind kind) {
  return static_cast<std::size_t>(std::ranges::count(stream.actions_, kind, &LinkAction::kind));
}

/// Streams to three servers, with a window of ten frames.
class StreamToAFleet : public testing::Test {
 protected:
  static StreamOptions options() { return {.order = Order::kDone, .max_in_flight = 10, .max_waiting = 10}; }

  /// Lets every connection send what it can; how many frames began on each of the first three.
  static std::vector<std::size_t> begun(StreamHarness& stream) {
    std::vector<std::size_t> begun(3);
    for (int round = 0; round < 10; ++round) {
      for (std::size_t i = 0; i < 3; ++i) begun[i] += stream.begun_on(i + 1);
    }
    return begun;
  }
};

TEST_F(StreamToAFleet, ConnectsToAllServersAtOnceAndSpreadsItsFrames) {
  StreamHarness stream(options(), kThree);
  stream.open_all();
  EXPECT_EQ(stream.connections_.size(), 3U);
  for (int i = 0; i < 6; ++i) stream.send();
  EXPECT_THAT(begun(stream), ElementsAre(2, 2, 2));
}

TEST_F(StreamToAFleet, OneServerIsEnoughToBegin) {
  StreamHarness stream(options(), kThree);
  stream.act();
  stream.open_on(2);
  stream.send();
  EXPECT_THAT(begun(stream), ElementsAre(0, 1, 0));
}

TEST_F(StreamToAFleet, ASlowServerGetsFewerFramesAndHoldsNoOthersUp) {
  StreamHarness stream(options(), kThree);
  stream.open_all(2);
  std::vector<std::uint64_t> ended(3);
  std::vector<std::size_t> open(3);
  for (int step = 0; step < 100; ++step) {
    if (stream.scheduler_.admission() == StreamScheduler::Admission::kOpen) stream.send();
    const auto now_begun = begun(stream);
    for (std::size_t i = 0; i < 3; ++i) open[i] += now_begun[i];
    stream.pass(milliseconds(10));
    for (std::size_t i = 0; i < 3; ++i) {
      const bool is_done = i == 0 ? step % 30 == 29 : true;  // the first takes 300 ms, the others 10
      if (!is_done || open[i] == 0) continue;
      stream.end_on(i + 1, ++ended[i]);
      --open[i];
    }
    stream.taken();
  }
  EXPECT_LE(ended[0], 5U);
  EXPECT_GE(ended[1] + ended[2], 90U);
}

TEST_F(StreamToAFleet, AServerThatIsFullDoesNotHoldUpTheOthers) {
  StreamHarness stream(options(), {"a", "b"});
  stream.act();
  stream.open_on(1, 1);
  stream.open_on(2, 10);
  for (int i = 0; i < 6; ++i) stream.send();
  std::size_t at_first = 0, at_second = 0;
  for (int round = 0; round < 10; ++round) {
    at_first += stream.begun_on(1);
    at_second += stream.begun_on(2);
  }
  EXPECT_EQ(at_first, 1U);
  EXPECT_EQ(at_second, 5U);
}

TEST_F(StreamToAFleet, AServerWithoutRoomRestsWhileTheOtherTakesItsFrames) {
  StreamHarness stream(options(), {"a", "b"});
  stream.act();
  stream.open_on(1);
  stream.send();
  EXPECT_EQ(stream.begun_on(1), 1U);
  stream.open_on(2);
  wire::ErrorDetails details{.reason = wire::ErrorReason::kQueueFull, .retry_delay = milliseconds(3000)};
  v1::SegmentStreamResponse full = StreamHarness::outcome(1, v1::OUTCOME_KIND_FAILED);
  *full.mutable_outcome()->mutable_status() =
      wire::to_message(wire::with_details(absl::ResourceExhaustedError("full"), details));
  stream.answer(full, 1);
  stream.send();
  EXPECT_EQ(stream.begun_on(1), 0U);
  EXPECT_EQ(stream.begun_on(2), 2U) << "at once";
  stream.answer(full, 2);
  stream.end_on(2, 2);
  EXPECT_EQ(stream.taken().size(), 1U);
  EXPECT_EQ(stream.begun_on(1) + stream.begun_on(2), 0U) << "now both rest";
  stream.pass(milliseconds(3000));
  EXPECT_EQ(stream.begun_on(1) + stream.begun_on(2), 1U);
}

TEST_F(StreamToAFleet, AServerThatBreaksEveryConnectionGetsNoFrameTwice) {
  StreamHarness stream(options(), {"a", "b"});
  stream.act();
  stream.open_on(1);
  stream.send();
  EXPECT_EQ(stream.begun_on(1), 1U);
  stream.scheduler_.on_closed(1, absl::UnavailableError("crashed"), stream.now_);
  stream.pass(milliseconds(50));
  ASSERT_EQ(stream.connections_.size(), 3U);
  stream.open_on(3);
  stream.open_on(2);
  EXPECT_EQ(stream.begun_on(3), 0U);
  EXPECT_EQ(stream.begun_on(2), 1U);
}

TEST_F(StreamToAFleet, AServerThatDiesLosesItsFramesToTheOthers) {
  StreamHarness stream(options(), kThree);
  stream.open_all();
  for (int i = 0; i < 6; ++i) stream.send();
  begun(stream);
  stream.scheduler_.on_closed(1, absl::UnavailableError("killed"), stream.now_);
  EXPECT_THAT(begun(stream), ElementsAre(0, 1, 1));
  for (const ConnectionId id : {2, 3}) {
    for (const std::uint64_t number : {1, 2, 3}) stream.end_on(id, number);
  }
  EXPECT_EQ(stream.taken().size(), 6U);
}

TEST_F(StreamToAFleet, AServerThatRefusesTheStreamIsLeftAlone) {
  StreamHarness stream(options(), {"a", "b"});
  stream.act();
  stream.open_on(2);
  stream.send();
  stream.scheduler_.on_closed(1, absl::UnimplementedError("no streams here"), stream.now_);
  EXPECT_EQ(stream.begun_on(2), 1U);
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kOpen);
  stream.scheduler_.on_closed(2, absl::UnimplementedError("nor here"), stream.now_);
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_EQ(stream.scheduler_.admission(), StreamScheduler::Admission::kRefused);
}

TEST_F(StreamToAFleet, ServersThatLeaveTheListFinishAndNewOnesGetTheirShare) {
  StreamHarness stream(options(), {"a", "b"});
  stream.open_all();
  for (int i = 0; i < 2; ++i) stream.send();
  begun(stream);
  stream.set_servers({"b", "c"});
  stream.act();
  ASSERT_EQ(stream.connections_.size(), 3U);
  EXPECT_EQ(stream.actions_.back().server.address, "c");
  stream.open_on(3);
  EXPECT_TRUE(stream.scheduler_.wants_half_close(1));
  for (int i = 0; i < 3; ++i) stream.send();
  EXPECT_THAT(begun(stream), ElementsAre(0, 1, 2));
  stream.end_on(1, 1);
  EXPECT_EQ(stream.taken().size(), 1U);
  stream.scheduler_.on_closed(1, absl::OkStatus(), stream.now_);
  stream.act();
  EXPECT_EQ(stream.connections_.size(), 3U) << "it is not connected to again";
}

TEST_F(StreamToAFleet, WithMoreServersThanConnectionsEachStreamUsesOthers) {
  std::vector<std::string> many;
  for (int i = 0; i < 40; ++i) many.push_back(std::to_string(i));
  StreamHarness stream({.max_servers = 3}, many);
  stream.act();
  EXPECT_EQ(stream.connections_.size(), 3U);
  EXPECT_NE(stream.actions_[2].server.address, "2");
  stream.open_all();
  stream.scheduler_.on_closed(1, absl::UnavailableError("killed"), stream.now_);
  stream.act();
  ASSERT_EQ(stream.connections_.size(), 4U) << "another takes its place";
  EXPECT_NE(stream.actions_[3].server.id, stream.actions_[0].server.id);
}

TEST_F(StreamToAFleet, WithoutAnAnswerForItsNameItWaitsOrElseFails) {
  StreamHarness patient(options(), {});
  patient.send();
  patient.act();
  EXPECT_THAT(patient.taken(), IsEmpty());
  patient.scheduler_.set_servers({.servers = {}, .trouble = absl::UnavailableError("robots is not known")});
  patient.act();
  EXPECT_THAT(patient.taken(), IsEmpty());
  patient.set_servers({"a"});
  patient.open();
  EXPECT_EQ(patient.begun(), 1U);

  StreamOptions hasty = options();
  hasty.wait_for_server = false;
  StreamHarness stream(hasty, {});
  stream.send();
  stream.act();
  EXPECT_THAT(stream.taken(), IsEmpty()) << "the name is still being looked up";
  stream.scheduler_.set_servers({.servers = {}, .trouble = absl::UnavailableError("robots is not known")});
  stream.act();
  EXPECT_THAT(stream.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
  EXPECT_EQ(stream.last_.status.message(), "robots is not known");
}

/// A stream to two servers, of which the first has a frame and falls silent.
class ASilentServer : public testing::Test {
 protected:
  ASilentServer() {
    stream_.act();
    stream_.open_on(1);
    stream_.send();
    EXPECT_EQ(stream_.begun_on(1), 1U);
    stream_.open_on(2);
  }

  StreamHarness stream_{{.order = Order::kDone, .max_in_flight = 10, .max_waiting = 10}, {"a", "b"}};
};

TEST_F(ASilentServer, IsSuspectOneSecondLaterAndItsFrameGoesElsewhereToo) {
  stream_.pass(milliseconds(500));
  EXPECT_EQ(stream_.actions_.back().kind, LinkAction::kProbe);
  EXPECT_EQ(stream_.begun_on(2), 0U);
  stream_.pass(milliseconds(500));
  EXPECT_EQ(stream_.begun_on(2), 1U);
  stream_.send();
  EXPECT_EQ(stream_.begun_on(1), 0U) << "it gets no new frames";
  EXPECT_EQ(stream_.begun_on(2), 1U);
  stream_.end_on(2, 1);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  EXPECT_TRUE(stream_.last_.report.hedged);
  EXPECT_EQ(stream_.last_.report.attempts, 2U);
  EXPECT_EQ(stream_.last_.report.address, "b");
  EXPECT_EQ(count_of(stream_, LinkAction::kBreakSilent), 0U);
}

TEST_F(ASilentServer, ThatComesToLifeAgainIsUsedAgainAndMayBeFirst) {
  stream_.pass(milliseconds(500));
  stream_.pass(milliseconds(500));
  EXPECT_EQ(stream_.begun_on(2), 1U);
  stream_.end_on(1, 1);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  EXPECT_EQ(stream_.last_.report.address, "a");
  const auto messages = stream_.sent(2);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages[0].has_cancel()) << "the other one need not compute it";
  stream_.end_on(2, 1);
  EXPECT_THAT(stream_.taken(), IsEmpty());
  stream_.send();
  stream_.send();
  EXPECT_EQ(stream_.begun_on(1) + stream_.begun_on(2) + stream_.begun_on(1), 2U);
}

TEST_F(ASilentServer, IsGivenUpAfterTheProgressTimeout) {
  for (int i = 0; i < 9; ++i) stream_.pass(milliseconds(500));
  EXPECT_EQ(count_of(stream_, LinkAction::kBreakSilent), 0U);
  stream_.pass(milliseconds(500));
  EXPECT_EQ(count_of(stream_, LinkAction::kBreakSilent), 1U);
}

TEST_F(ASilentServer, ThatAnswersItsProbeComputesForLongAndIsTrusted) {
  for (int i = 0; i < 40; ++i) {
    stream_.pass(milliseconds(500));
    stream_.scheduler_.on_probe_answered(1, stream_.now_);
  }
  EXPECT_EQ(count_of(stream_, LinkAction::kBreakSilent), 0U);
  EXPECT_EQ(stream_.begun_on(2), 0U);
}

TEST_F(ASilentServer, ALostServerLeavesTheFrameToTheOther) {
  stream_.pass(milliseconds(500));
  stream_.pass(milliseconds(500));
  EXPECT_EQ(stream_.begun_on(2), 1U);
  stream_.scheduler_.on_closed(1, absl::UnavailableError("killed"), stream_.now_);
  EXPECT_EQ(stream_.begun_on(2), 0U) << "it is there already";
  stream_.end_on(2, 1);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
}

/// A stream to two servers that sends late frames to the other one after 100 ms.
class AHedgedStream : public testing::Test {
 protected:
  AHedgedStream() { stream_.open_all(100); }

  /// Sends a frame, and takes the result from the server that has got it.
  void send_and_end() {
    stream_.send();
    for (const ConnectionId id : {1, 2}) {
      for (const std::uint64_t number : StreamHarness::headers(stream_.sent(id))) stream_.end_on(id, number);
    }
    stream_.taken();
  }
  std::size_t begun() { return stream_.begun_on(1) + stream_.begun_on(2) + stream_.begun_on(1); }

  StreamHarness stream_{
      {.order = Order::kDone, .max_in_flight = 100, .max_waiting = 100, .hedge_after = milliseconds(100)}, {"a", "b"}};
};

TEST_F(AHedgedStream, ALateFrameGoesToASecondServer) {
  stream_.send();
  EXPECT_EQ(begun(), 1U);
  EXPECT_EQ(stream_.scheduler_.tick(stream_.now_).wake_at, stream_.now_ + milliseconds(100));
  stream_.pass(milliseconds(99));
  EXPECT_EQ(begun(), 0U);
  stream_.pass(milliseconds(1));
  EXPECT_EQ(begun(), 1U);
  stream_.end_on(2, 1);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(1, OutcomeKind::kResult)));
  EXPECT_TRUE(stream_.last_.report.hedged);
  EXPECT_EQ(stream_.last_.report.address, "b");
  stream_.end_on(1, 1);
  EXPECT_THAT(stream_.taken(), IsEmpty());
}

TEST_F(AHedgedStream, IfTheSecondServerFailsTheFirstStillCounts) {
  stream_.send();
  EXPECT_EQ(begun(), 1U);
  stream_.pass(milliseconds(100));
  EXPECT_EQ(begun(), 1U);
  for (const ConnectionId id : {1, 2}) {
    v1::SegmentStreamResponse busy = StreamHarness::outcome(1, v1::OUTCOME_KIND_FAILED);
    *busy.mutable_outcome()->mutable_status() = wire::to_message(absl::ResourceExhaustedError("full"));
    stream_.answer(busy, id);
    EXPECT_THAT(stream_.taken(), IsEmpty());
    EXPECT_EQ(begun(), 0U);
  }
  stream_.pass(milliseconds(1000));
  EXPECT_EQ(begun(), 1U) << "now both have failed, and it is sent again";
}

TEST_F(AHedgedStream, AFrameThatIsWrongEndsAtTheFirstAnswer) {
  stream_.send();
  EXPECT_EQ(begun(), 1U);
  stream_.pass(milliseconds(100));
  EXPECT_EQ(begun(), 1U);
  v1::SegmentStreamResponse wrong = StreamHarness::outcome(1, v1::OUTCOME_KIND_FAILED);
  *wrong.mutable_outcome()->mutable_status() = wire::to_message(absl::InvalidArgumentError("no cloud"));
  stream_.answer(wrong, 2);
  EXPECT_THAT(stream_.taken(), ElementsAre(ended(1, OutcomeKind::kFailed)));
}

TEST_F(AHedgedStream, AtMostOneFrameInTenIsSentTwice) {
  for (int i = 0; i < 50; ++i) send_and_end();
  for (int i = 0; i < 50; ++i) stream_.send();
  for (int round = 0; round < 60; ++round) begun();
  stream_.pass(milliseconds(100));
  std::size_t copies = 0;
  for (int round = 0; round < 60; ++round) copies += begun();
  EXPECT_GE(copies, 5U);
  EXPECT_LE(copies, 11U);
}

TEST(StreamScheduler, WithOneServerNothingIsSentTwice) {
  StreamHarness stream({.hedge_after = milliseconds(10)}, {"a"});
  stream.open();
  stream.send();
  EXPECT_EQ(stream.begun(), 1U);
  stream.pass(milliseconds(2000));
  EXPECT_EQ(stream.begun(), 0U);
  EXPECT_EQ(stream.actions_.size(), 1U) << "there is no hurry to probe it";
}

}  // namespace
}  // namespace segserve::client
