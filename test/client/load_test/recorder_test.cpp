// SPDX-License-Identifier: Apache-2.0
// Tests what is counted where, with times that the test makes up.
#include "client/load_test/recorder.hpp"

#include <chrono>

#include "client/load_test/findings.hpp"
#include "gmock/gmock.h"

namespace segserve::bench {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

client::Outcome result_outcome() {
  client::Outcome outcome;
  outcome.kind = client::OutcomeKind::kResult;
  outcome.result.emplace();
  return outcome;
}

/// A run of 4 s after a warm-up of 2 s, that began long ago.
class RecorderTest : public testing::Test {
 protected:
  client::Time at(double s) const {
    return clock_.measured_from() +
           std::chrono::duration_cast<client::Clock::duration>(std::chrono::duration<double>(s));
  }
  /// A frame was due, was sent so much later, and got its result.
  void frame(double due, double late, double done, std::size_t client = 0) {
    const SentFrame sent{.client = client, .intended = at(due), .actual = at(due + late)};
    recorder_.on_offered(sent.intended);
    recorder_.on_sent(sent);
    client::Outcome outcome = result_outcome();
    outcome.report.header_sent = at(due + late) + milliseconds(10);
    recorder_.on_outcome(sent, outcome, {.points = 100}, at(done));
  }
  void lose(double due) {
    const SentFrame sent{.intended = at(due), .actual = at(due)};
    recorder_.on_offered(sent.intended);
    recorder_.on_lost(sent, "UNFINISHED", at(due));
  }
  Report total() const {
    Report total;
    for (std::size_t i = 0; i < recorder_.levels(); ++i) {
      const Report level = recorder_.of_level(i);
      total.add(level);
      total.seconds += level.seconds;
    }
    return total;
  }

  RunClock clock_{client::Clock::now() - seconds(100), seconds(2), seconds(4), seconds(10)};
  Recorder recorder_{clock_, {seconds(1), seconds(4)}, 1, 2, 1};
};

TEST_F(RecorderTest, ThroughputIsWhatFinishedWithinTheWindow) {
  for (int i = -20; i < 40; ++i) frame(0.1 * i, 0, 0.1 * i + 3.05);  // 10 frames/s whose results take 3 s
  EXPECT_DOUBLE_EQ(total().seconds, 4);
  EXPECT_EQ(total().sent, 40U) << "frames of the warm-up are not measured";
  EXPECT_EQ(total().results, 40U) << "results after the window count for its frames";
  EXPECT_EQ(total().finished, 30U) << "and those within it for the throughput, also of frames of the warm-up";
  EXPECT_DOUBLE_EQ(total().frames_per_second(), 30 / 4.0);
  EXPECT_NEAR(total().latency.percentile(50), 3050, 3);
}

TEST_F(RecorderTest, TheShareOfAClientIsOfWhatFinishedToo) {
  for (int i = 0; i < 30; ++i) frame(0.1 * i, 0, 0.1 * i + 0.05, 0);
  for (int i = 0; i < 30; ++i) frame(-1 + 0.1 * i, 0, -1 + 0.1 * i + 1.01, 1);
  EXPECT_THAT(total().finished_of_client, testing::ElementsAre(30, 30));
  EXPECT_DOUBLE_EQ(total().least_share_percent(), 100);
}

TEST_F(RecorderTest, LatencyCountsFromTheIntendedTimeAndSinceSentFromTheWire) {
  frame(1, 0.5, 2);
  EXPECT_NEAR(total().latency.percentile(50), 1000, 1);
  EXPECT_NEAR(total().since_sent.percentile(50), 490, 1) << "without the client's own queue";
  EXPECT_EQ(total().late, 1U);
}

TEST_F(RecorderTest, FramesBelongToTheLevelInWhichTheyWereDue) {
  frame(0.5, 0, 1.5);
  frame(1.0, 0, 1.5);
  lose(2);
  lose(-1);
  EXPECT_EQ(recorder_.of_level(0).results, 1U);
  EXPECT_EQ(recorder_.of_level(0).finished, 0U);
  EXPECT_EQ(recorder_.of_level(1).results, 1U);
  EXPECT_EQ(recorder_.of_level(1).finished, 2U);
  EXPECT_EQ(recorder_.of_level(1).failed(), 1U);
  EXPECT_DOUBLE_EQ(recorder_.of_level(1).seconds, 3);
}

TEST_F(RecorderTest, AWindowThatEndsEarlyIsShorter) {
  frame(0.2, 0, 0.3);
  clock_.stop(at(0.5), seconds(0));
  frame(0.7, 0, 0.8);
  EXPECT_DOUBLE_EQ(total().seconds, 0.5);
  EXPECT_EQ(total().sent, 1U);
  EXPECT_FALSE(clock_.sleep_until(at(3)));
}

TEST_F(RecorderTest, TheTimelineHasEachIntervalFromTheWarmUpOn) {
  const auto close = [&](double s) { recorder_.close_interval(at(s), 0.25, 1000, false, {}); };
  frame(-1.5, 0, -1.2);
  close(-1);
  close(0);
  frame(0.5, 0.1, 0.9);
  EXPECT_FALSE(recorder_.close_interval(at(0.99), 0, 0, false, {}));
  close(1);
  lose(1.5);
  close(2);
  const auto timeline = recorder_.timeline();
  ASSERT_EQ(timeline.size(), 4U);
  EXPECT_DOUBLE_EQ(timeline[0].t, -2);
  EXPECT_EQ(timeline[0].results, 1U);
  EXPECT_FALSE(timeline[1].p50_ms);
  EXPECT_DOUBLE_EQ(timeline[2].t, 0);
  EXPECT_EQ(timeline[2].late, 1U);
  EXPECT_NEAR(*timeline[2].p99_ms, 400, 1);
  EXPECT_DOUBLE_EQ(timeline[2].client_busy_cpus, 0.25);
  EXPECT_EQ(timeline[3].failed, 1U);
}

TEST(Findings, AnOpenLoopThatFallsBehindIsUnstable) {
  LoadOptions options;
  options.rates = {{100, 100, 10}};
  LoadResult result;
  Report part;
  part.seconds = 10;
  for (int i = 0; i < 1000; ++i) part.add(result_outcome(), {.latency_ms = 5});
  for (int i = 0; i < 600; ++i) part.add_finished(0, 1);
  result.parts = {{part}};
  result.window_s = 10;
  result.summarize();
  const auto codes = [&] {
    std::vector<std::string> all;
    for (const Finding& finding : findings(options, result)) all.push_back(finding.code);
    return all;
  };
  EXPECT_THAT(codes(), testing::ElementsAre("UNSTABLE", "TOO_FEW_SAMPLES"));
  for (int i = 0; i < 400; ++i) result.parts[0][0].add_finished(0, 1);
  result.summarize();
  EXPECT_THAT(codes(), testing::ElementsAre("TOO_FEW_SAMPLES"));

  // The latency doubles in the last third.
  for (int second = 0; second < 9; ++second) {
    const double p50 = second < 6 ? 5 : 10;
    result.timeline.push_back({.t = 1.0 * second, .seconds = 1, .results = 100, .p50_ms = p50});
  }
  EXPECT_THAT(codes(), testing::ElementsAre("UNSTABLE", "TOO_FEW_SAMPLES"));
  result.cpu_seconds = 15;
  result.cpus = 2;
  EXPECT_THAT(codes(), testing::ElementsAre("UNSTABLE", "TOO_FEW_SAMPLES"));
  result.cpu_seconds = 17;
  EXPECT_THAT(codes(), testing::ElementsAre("UNSTABLE", "CLIENT_WAS_THE_LIMIT", "TOO_FEW_SAMPLES"));
}

}  // namespace
}  // namespace segserve::bench
