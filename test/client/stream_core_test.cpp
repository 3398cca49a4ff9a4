// What a stream decides, without transport: the test is the clock and the server.
#include "segserve/client/stream_core.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "segserve/wire/byte_run.hpp"
#include "segserve/wire/status.hpp"
#include "test/client/outgoing_message.hpp"
#include "test/client/scenes.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using Request = v1::SegmentStreamRequest;
using Response = v1::SegmentStreamResponse;

/// A core between an application and servers that do what the test says.
class Bench {
 public:
  explicit Bench(StreamOptions options = {}, std::vector<std::string> addresses = {"a", "b"})
      : core_(options, std::move(addresses), 0, 1), payload_(*cloud_payload(flat_cloud(10, 10))) {}

  std::uint64_t send(FrameOptions options = {}) { return core_.accept(payload_, std::move(options), now_); }

  void pass(milliseconds time) {
    now_ += time;
    act();
  }

  /// Lets the core act; remembers the connections that it wants.
  void act() {
    for (const auto& action : core_.tick(now_).actions) {
      actions_.push_back(action);
      if (action.kind == StreamCore::Action::kOpen) connections_.push_back(action.connection);
    }
  }

  /// Everything that a connection has to say now.
  std::vector<Request> sent(StreamCore::ConnectionId id) {
    std::vector<Request> messages;
    for (Outgoing outgoing; core_.next_message(id, outgoing, now_);) messages.push_back(received(outgoing));
    return messages;
  }
  std::vector<Request> sent() { return sent(connections_.back()); }

  /// Numbers on the wire of the frames begun in these messages.
  static std::vector<std::uint64_t> headers(const std::vector<Request>& messages) {
    std::vector<std::uint64_t> numbers;
    for (const Request& message : messages) {
      if (message.has_frame()) numbers.push_back(message.frame().sequence());
    }
    return numbers;
  }
  std::size_t begun() { return headers(sent()).size(); }

  void answer(Response response, std::size_t connection = 0) {
    core_.on_message(connection == 0 ? connections_.back() : connection, response, now_);
  }

  void open(std::uint32_t frames = 4, std::uint64_t bytes = 1'000'000) {
    act();
    sent();
    Response response;
    response.mutable_opened()->mutable_credit()->set_frames(frames);
    response.mutable_opened()->mutable_credit()->set_bytes(bytes);
    response.mutable_opened()->set_max_chunk_bytes(256 << 10);
    answer(response);
  }

  static Response outcome(std::uint64_t number, v1::OutcomeKind kind) {
    Response response;
    response.mutable_outcome()->set_sequence(number);
    response.mutable_outcome()->set_kind(kind);
    return response;
  }
  void end(std::uint64_t number, v1::OutcomeKind kind = v1::OUTCOME_KIND_RESULT) { answer(outcome(number, kind)); }
  void fail(std::uint64_t number, const absl::Status& status) {
    Response response = outcome(number, v1::OUTCOME_KIND_FAILED);
    *response.mutable_outcome()->mutable_status() = wire::to_message(status);
    answer(response);
  }
  void close(const absl::Status& status) { core_.on_closed(connections_.back(), status, now_); }

  /// Sequence and kind of all outcomes that can be taken.
  std::vector<std::pair<std::uint64_t, OutcomeKind>> taken() {
    std::vector<std::pair<std::uint64_t, OutcomeKind>> ends;
    while (auto raw = core_.take_outcome()) {
      ends.emplace_back(raw->outcome.sequence, raw->outcome.kind);
      last_ = raw->outcome;
    }
    return ends;
  }

  StreamCore core_;
  Payload payload_;
  Time now_{std::chrono::hours(1)};
  std::vector<StreamCore::Action> actions_;
  std::vector<StreamCore::ConnectionId> connections_;
  Outcome last_;
};

std::pair<std::uint64_t, OutcomeKind> ended(std::uint64_t sequence, OutcomeKind kind) { return {sequence, kind}; }

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
