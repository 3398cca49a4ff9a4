// SPDX-License-Identifier: Apache-2.0
// Streams against servers that misbehave. Every frame ends exactly once, and none is lost.
#include "segserve/client/stream.hpp"

#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "segserve/client/client.hpp"
#include "segserve/segment.hpp"
#include "test/client/client_scenes.hpp"
#include "test/client/fake_server.hpp"

namespace segserve::client {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

class StreamTest : public testing::Test {
 protected:
  Client client() const { return *Client::connect({.address = a_.address() + "," + b_.address()}); }
  Client client_of_a() const { return *Client::connect({.address = a_.address()}); }

  static StreamOptions options() {
    StreamOptions options;
    options.retry.first_backoff = milliseconds(5);
    options.retry.max_backoff = milliseconds(100);
    options.frame_timeout = milliseconds(60'000);
    return options;
  }

  /// Sends the frames on a thread of its own, and returns all outcomes.
  static std::vector<Outcome> run(Stream& stream, const std::vector<Cloud>& frames) {
    std::vector<Outcome> outcomes;
    std::thread sender([&] {
      for (const Cloud& frame : frames) EXPECT_TRUE(stream.send(frame).ok());
      stream.finish();
    });
    while (auto outcome = stream.next()) outcomes.push_back(*std::move(outcome));
    sender.join();
    return outcomes;
  }

  static std::vector<Cloud> many(std::size_t count) { return std::vector<Cloud>(count, flat_cloud(20, 20)); }

  static void expect_all_results(const std::vector<Outcome>& outcomes, std::size_t count) {
    ASSERT_EQ(outcomes.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(outcomes[i].sequence, i + 1);
      EXPECT_EQ(outcomes[i].kind, OutcomeKind::kResult) << outcomes[i].status;
    }
  }

  FakeServer a_, b_;
};

TEST_F(StreamTest, GivesWhatTheCoreGives) {
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  ASSERT_TRUE(local.ok());
  auto stream = client_of_a().open_stream(options());
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto outcomes = run(*stream, {cloud, flat_cloud(8, 8), cloud});
  expect_all_results(outcomes, 3);
  for (const std::size_t i : {0, 2}) {
    EXPECT_EQ(outcomes[i].result->segmentation.labels, local->labels);
    EXPECT_EQ(outcomes[i].result->segmentation.supervoxels, local->supervoxels);
    EXPECT_EQ(outcomes[i].result->segmentation.tree, local->tree);
  }
  EXPECT_TRUE(stream->done());
}

TEST_F(StreamTest, EchoesAndReports) {
  auto stream = client_of_a().open_stream(options());
  ASSERT_TRUE(stream.ok()) << stream.status();
  const auto stamp = std::chrono::system_clock::now();
  ASSERT_TRUE(stream->send(flat_cloud(8, 8), {.request_id = "r", .frame_id = "camera", .stamp = stamp}).ok());
  const auto outcome = stream->next();
  ASSERT_TRUE(outcome && outcome->kind == OutcomeKind::kResult) << outcome->status;
  EXPECT_EQ(outcome->request_id, "r");
  EXPECT_EQ(outcome->frame_id, "camera");
  EXPECT_EQ(outcome->stamp, stamp);
  const FrameReport& report = outcome->report;
  EXPECT_EQ(report.address, a_.address());
  EXPECT_EQ(report.attempts, 1U);
  EXPECT_GT(report.bytes_sent, 64U * 15);
  EXPECT_GT(report.bytes_received, 0U);
  EXPECT_LE(report.handed_over, report.header_sent);
  EXPECT_LE(report.header_sent, report.payload_sent);
  EXPECT_LE(report.payload_sent, report.outcome_begun);
  EXPECT_LE(report.outcome_begun, report.outcome_done);
}

TEST_F(StreamTest, AFailedFrameDoesNotEndTheStream) {
  a_.answer = [](const auto& header) { return header.sequence() == 2 ? FakeServer::kInvalid : FakeServer::kResult; };
  auto stream = client_of_a().open_stream(options());
  const auto outcomes = run(*stream, many(3));
  ASSERT_EQ(outcomes.size(), 3U);
  EXPECT_EQ(outcomes[1].kind, OutcomeKind::kFailed);
  EXPECT_TRUE(absl::IsInvalidArgument(outcomes[1].status)) << outcomes[1].status;
  EXPECT_EQ(outcomes[2].kind, OutcomeKind::kResult);
}

TEST_F(StreamTest, SendsAgainWhatArrivedDamagedOrFoundNoRoom) {
  std::atomic<int> asked{0};
  a_.answer = [&asked](const auto&) {
    constexpr std::array kAnswers{FakeServer::kChecksum, FakeServer::kBusy, FakeServer::kDamagedResult};
    const int n = asked++;
    return n < 3 ? kAnswers[static_cast<std::size_t>(n)] : FakeServer::kResult;
  };
  auto stream = client_of_a().open_stream(options());
  const auto outcomes = run(*stream, many(1));
  expect_all_results(outcomes, 1);
  EXPECT_EQ(outcomes[0].report.attempts, 4U);
  EXPECT_EQ(a_.streams, 1);
}

TEST_F(StreamTest, GivesUpAFrameThatNeverArrivesWhole) {
  a_.answer = [](const auto&) { return FakeServer::kChecksum; };
  auto stream = client_of_a().open_stream(options());
  const auto outcomes = run(*stream, many(1));
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_TRUE(absl::IsAborted(outcomes[0].status)) << outcomes[0].status;
  EXPECT_EQ(outcomes[0].report.attempts, RetryOptions{}.max_attempts);
}

TEST_F(StreamTest, ABrokenStreamIsReopenedAndNothingIsLost) {
  std::atomic<int> asked{0};
  const auto sometimes_break = [&asked](const auto&) {
    return asked++ % 7 == 3 ? FakeServer::kBreak : FakeServer::kResult;
  };
  a_.answer = b_.answer = sometimes_break;
  auto stream = client().open_stream(options());
  expect_all_results(run(*stream, many(40)), 40);
  // Who got which of the frames is left to chance.
  EXPECT_GT(a_.streams + b_.streams, 2);
}

TEST_F(StreamTest, AServerThatBreaksTheProtocolIsLeft) {
  a_.answer = [](const auto&) { return FakeServer::kUnknownFrame; };
  auto stream = client().open_stream(options());
  expect_all_results(run(*stream, many(5)), 5);
  EXPECT_EQ(b_.answered, 5);
}

TEST_F(StreamTest, WhenOneOfTwoServersDiesNothingIsLost) {
  auto stream = client().open_stream(options());
  std::atomic<int> asked{0};
  a_.answer = b_.answer = [&asked](const auto&) {
    ++asked;
    return FakeServer::kResult;
  };
  std::thread killer([&] {
    while (asked < 20) std::this_thread::sleep_for(milliseconds(1));
    (a_.answered > 0 ? a_ : b_).stop();
  });
  expect_all_results(run(*stream, many(200)), 200);
  killer.join();
}

TEST_F(StreamTest, WhenOneOfTwoServersDrainsNothingIsLost) {
  auto stream = client().open_stream(options());
  std::atomic<int> asked{0};
  const auto count = [&](FakeServer& self) {
    return [&](const auto&) {
      if (++asked == 20) self.drains = true;
      return FakeServer::kResult;
    };
  };
  a_.answer = count(a_);
  b_.answer = count(b_);
  const auto outcomes = run(*stream, many(100));
  expect_all_results(outcomes, 100);
  EXPECT_GT(a_.answered, 0);
  EXPECT_GT(b_.answered, 0);
}

TEST_F(StreamTest, ASilentCutIsNoticedAndTheFrameGoesElsewhere) {
  StreamOptions impatient = options();
  impatient.progress_timeout = milliseconds(400);
  auto stream = client().open_stream(impatient);
  ASSERT_TRUE(stream->send(flat_cloud(8, 8)).ok());
  const auto first = stream->next();
  ASSERT_TRUE(first && first->kind == OutcomeKind::kResult) << first->status;
  FakeServer& used = first->report.address == a_.address() ? a_ : b_;
  FakeServer& other = first->report.address == a_.address() ? b_ : a_;
  used.go_silent();
  ASSERT_TRUE(stream->send(flat_cloud(8, 8)).ok());
  const auto second = stream->next();
  ASSERT_TRUE(second && second->kind == OutcomeKind::kResult) << second->status;
  EXPECT_EQ(second->report.address, other.address());
  used.stop();
}

TEST_F(StreamTest, AServerThatComputesForLongIsNotTakenForDead) {
  StreamOptions impatient = options();
  impatient.progress_timeout = milliseconds(200);
  a_.before_answer = [] { std::this_thread::sleep_for(milliseconds(1500)); };
  auto stream = client_of_a().open_stream(impatient);
  const auto outcomes = run(*stream, many(1));
  expect_all_results(outcomes, 1);
  EXPECT_EQ(outcomes[0].report.attempts, 1U);
  EXPECT_EQ(a_.streams, 1);
}

TEST_F(StreamTest, WaitsForAServerThatComesBack) {
  a_.stop();
  auto stream = client_of_a().open_stream(options());
  ASSERT_TRUE(stream->send(flat_cloud(8, 8)).ok());
  EXPECT_FALSE(stream->next(milliseconds(300)).has_value());
  a_.restart();
  const auto outcome = stream->next();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->kind, OutcomeKind::kResult) << outcome->status;
}

TEST_F(StreamTest, FailsAtOnceWithoutServerIfToldTo) {
  a_.stop();
  StreamOptions hasty = options();
  hasty.wait_for_server = false;
  auto stream = client_of_a().open_stream(hasty);
  const auto outcomes = run(*stream, many(2));
  ASSERT_EQ(outcomes.size(), 2U);
  for (const Outcome& outcome : outcomes) {
    EXPECT_TRUE(absl::IsUnavailable(outcome.status)) << outcome.status;
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr(a_.address()));
  }
}

TEST_F(StreamTest, SegmentsHereWithoutServerIfToldTo) {
  a_.stop();
  const Cloud cloud = table_scene();
  const auto local = segment(cloud, {});
  StreamOptions independent = options();
  independent.fallback_to_local = true;
  auto stream = client_of_a().open_stream(independent);
  const auto outcomes = run(*stream, {cloud, cloud});
  expect_all_results(outcomes, 2);
  EXPECT_TRUE(outcomes[0].report.local);
  EXPECT_EQ(outcomes[1].result->segmentation.labels, local->labels);
}

TEST_F(StreamTest, DescribesSegmentsHereWithoutServerIfAskedTo) {
  a_.stop();
  const Cloud cloud = table_scene();
  Segmentation local = segment(cloud, {}).value();
  ASSERT_TRUE(describe(cloud, 1, {}, local).ok());
  StreamOptions independent = options();
  independent.fallback_to_local = true;
  independent.outputs = {.labels = true, .segments = true};
  auto stream = client_of_a().open_stream(independent);
  const auto outcomes = run(*stream, {cloud});
  expect_all_results(outcomes, 1);
  EXPECT_EQ(outcomes[0].result->segmentation.statistics, local.statistics);
}

TEST_F(StreamTest, AServerWithoutStreamsIsAnErrorOfEveryFrame) {
  a_.refuses_streams = true;
  auto stream = client_of_a().open_stream(options());
  ASSERT_TRUE(stream->send(flat_cloud(8, 8)).ok());
  const auto outcome = stream->next();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_TRUE(absl::IsUnimplemented(outcome->status)) << outcome->status;
  EXPECT_TRUE(absl::IsUnimplemented(stream->send(flat_cloud(8, 8)).status()));
  EXPECT_FALSE(stream->next().has_value());
}

TEST_F(StreamTest, ACloudTooLargeForACallNeedsAServerWithStreams) {
  const Cloud large = incompressible_cloud(1'000'000);
  a_.answer = [](const auto&) { return FakeServer::kInvalid; };
  EXPECT_THAT(std::string(client_of_a().segment(large).status().message()), HasSubstr("no cloud at all"));
  EXPECT_EQ(a_.frames, 1);
  a_.refuses_streams = true;
  const auto refused = client_of_a().segment(large);
  EXPECT_EQ(wire::details_of(refused.status()).reason, wire::ErrorReason::kLimitExceeded) << refused.status();
}

TEST_F(StreamTest, AFrameBeyondTheCreditFailsAndSaysWhy) {
  a_.credit_bytes = 1000;
  auto stream = client_of_a().open_stream(options());
  const auto outcomes = run(*stream, {flat_cloud(8, 8), flat_cloud(20, 20)});
  ASSERT_EQ(outcomes.size(), 2U);
  EXPECT_EQ(outcomes[0].kind, OutcomeKind::kResult) << outcomes[0].status;
  EXPECT_EQ(wire::details_of(outcomes[1].status).reason, wire::ErrorReason::kLimitExceeded);
}

TEST_F(StreamTest, TheDeadlineOfAFrameHoldsWhateverTheServerDoes) {
  a_.answer = [](const auto&) { return FakeServer::kNothing; };
  auto stream = client_of_a().open_stream(options());
  ASSERT_TRUE(stream->send(flat_cloud(8, 8), {.timeout = milliseconds(100)}).ok());
  const auto outcome = stream->next();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_TRUE(absl::IsDeadlineExceeded(outcome->status)) << outcome->status;
}

TEST_F(StreamTest, RefusesOptionsThatMakeNoSenseAllAtOnce) {
  StreamOptions wrong;
  wrong.max_in_flight = 0;
  wrong.options.lambda = 7;
  wrong.progress_timeout = milliseconds(0);
  const auto stream = client().open_stream(wrong);
  EXPECT_TRUE(absl::IsInvalidArgument(stream.status())) << stream.status();
  EXPECT_EQ(wire::details_of(stream.status()).fields.size(), 3U);
}

TEST_F(StreamTest, TakesNoFrameAfterTheLast) {
  auto stream = client_of_a().open_stream(options());
  stream->finish();
  EXPECT_TRUE(absl::IsFailedPrecondition(stream->send(flat_cloud(8, 8)).status()));
  EXPECT_FALSE(stream->next().has_value());
}

}  // namespace
}  // namespace segserve::client
