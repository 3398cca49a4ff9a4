// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/stream_stats.hpp"

#include <gmock/gmock.h>

#include <sstream>
#include <string>

#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using namespace std::chrono_literals;
using Time = StreamStats::Time;

const Time kStart = Time(1000s);

client::Outcome result_after(std::chrono::milliseconds latency, Time now) {
  client::Outcome outcome;
  outcome.kind = client::OutcomeKind::kResult;
  outcome.report.outcome_done = now;
  outcome.report.handed_over = now - latency;
  outcome.result.emplace().segmentation.segments = 7;
  return outcome;
}

client::Outcome ended_as(client::OutcomeKind kind) {
  client::Outcome outcome;
  outcome.kind = kind;
  return outcome;
}

TEST(StreamStats, CountsEachEndOfAFrame) {
  StreamStats stats(kStart);
  for (int i = 0; i < 6; ++i) stats.add_frame(0ms);
  stats.add(result_after(10ms, kStart + 1s), kStart + 1s);
  stats.add(ended_as(client::OutcomeKind::kDropped), kStart + 1s);
  stats.add(ended_as(client::OutcomeKind::kExpired), kStart + 1s);
  stats.add(ended_as(client::OutcomeKind::kFailed), kStart + 1s);
  stats.add(ended_as(client::OutcomeKind::kCancelled), kStart + 1s);
  stats.add_failure();
  EXPECT_EQ(stats.frames(), 6U);
  EXPECT_EQ(stats.results(), 1U);
  EXPECT_EQ(stats.dropped(), 2U);
  EXPECT_EQ(stats.failed(), 2U);
  EXPECT_EQ(stats.segments(), 7U);
}

TEST(StreamStats, TellsThatTheRateWasNotKept) {
  StreamStats stats(kStart);
  stats.add_frame(StreamStats::kPunctual);
  EXPECT_EQ(stats.late(), 0U);
  EXPECT_THAT(stats.summary(kStart + 1s), testing::Not(testing::HasSubstr("rate was not kept")));
  stats.add_frame(300ms);
  stats.add_frame(120ms);
  EXPECT_THAT(stats.summary(kStart + 1s),
              testing::HasSubstr("; the rate was not kept: 2 frames were sent more than 50 ms late, up to 300 ms\n"));
  EXPECT_EQ(stats.summary_json(kStart + 1s)["late"], 2);
  EXPECT_EQ(stats.summary_json(kStart + 1s)["longest_delay_ms"], 300.0);
}

TEST(StreamStats, RateAndPercentilesAreThoseOfTheLastSeconds) {
  StreamStats stats(kStart);
  EXPECT_FALSE(stats.latency_ms(50, kStart));
  EXPECT_EQ(stats.rate(kStart), 0.0);
  for (int i = 1; i <= 100; ++i) stats.add(result_after(1ms * i, kStart + 20ms * i), kStart + 20ms * i);
  EXPECT_NEAR(stats.rate(kStart + 2s), 50.0, 1e-9) << "the stream is younger than the window";
  EXPECT_NEAR(*stats.latency_ms(50, kStart + 2s), 50.0, 1e-6);
  EXPECT_NEAR(*stats.latency_ms(95, kStart + 2s), 95.0, 1e-6);
  EXPECT_NEAR(*stats.latency_ms(100, kStart + 2s), 100.0, 1e-6);
  // Eleven seconds later only the results of the last ten count.
  for (int i = 1; i <= 20; ++i) stats.add(result_after(500ms, kStart + 10s + 100ms * i), kStart + 10s + 100ms * i);
  EXPECT_NEAR(*stats.latency_ms(0, kStart + 13s), 500.0, 1e-6);
  EXPECT_NEAR(stats.rate(kStart + 13s), 2.0, 1e-9);
  EXPECT_FALSE(stats.latency_ms(50, kStart + 60s));
}

TEST(StreamStats, TheTableFitsTheWindow) {
  StreamStats stats(kStart);
  stats.add_frame(0ms);
  stats.add(result_after(12ms, kStart + 1s), kStart + 1s);
  for (const std::size_t columns : {1U, 20U, 40U, 80U, 200U}) {
    std::istringstream lines(stats.table(kStart + 1s, columns));
    std::string names, figures, rest;
    std::getline(lines, names);
    std::getline(lines, figures);
    EXPECT_FALSE(std::getline(lines, rest));
    EXPECT_EQ(names.size(), figures.size()) << "columns are aligned";
    EXPECT_LT(names.size(), columns);
  }
  const std::string wide = stats.table(kStart + 1s, 200);
  EXPECT_THAT(wide, testing::HasSubstr("segments\n"));
  EXPECT_THAT(wide, testing::HasSubstr("12.0"));
}

TEST(StreamStats, TheSummaryIsOfTheWholeStream) {
  StreamStats stats(kStart);
  for (int i = 1; i <= 50; ++i) stats.add_frame(0ms);
  for (int i = 1; i <= 50; ++i) stats.add(result_after(20ms, kStart + 1s), kStart + 1s);
  const auto json = stats.summary_json(kStart + 100s);
  EXPECT_EQ(json["results"], 50);
  EXPECT_NEAR(json["rate"].get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(json["p95_ms"].get<double>(), 20.0, 0.5);
  EXPECT_THAT(stats.summary(kStart + 100s),
              testing::StartsWith("50 frames, 50 results, 0 dropped, 0 failed in 100.0 s"));
  EXPECT_TRUE(StreamStats(kStart).summary_json(kStart)["p50_ms"].is_null());
}

}  // namespace
}  // namespace segserve::segctl
