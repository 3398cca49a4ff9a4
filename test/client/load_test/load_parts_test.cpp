// SPDX-License-Identifier: Apache-2.0
// The parts of the load test behind `segctl bench`.
#include <cmath>
#include <vector>

#include "client/load_test/arrivals.hpp"
#include "client/load_test/findings.hpp"
#include "client/load_test/latencies.hpp"
#include "client/load_test/load_report.hpp"
#include "client/load_test/objective.hpp"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace segserve::bench {
namespace {

TEST(Latencies, PercentilesAreNearestRanks) {
  Latencies latencies;
  EXPECT_EQ(latencies.percentile(99), 0);
  for (int i = 1000; i >= 1; --i) latencies.add(i / 1000.0);  // 1 to 1000 us: each has a bucket of its own
  EXPECT_EQ(latencies.percentile(50), 0.5);
  EXPECT_EQ(latencies.percentile(99), 0.99);
  EXPECT_EQ(latencies.percentile(99.9), 0.999);
  EXPECT_EQ(latencies.percentile(100), 1);
  EXPECT_EQ(latencies.percentile(0), 0.001);
  EXPECT_EQ(latencies.max(), 1);
  EXPECT_DOUBLE_EQ(latencies.mean(), 0.5005);

  Latencies one;
  one.add(7);
  EXPECT_EQ(one.percentile(50), 7);
  one.add(latencies);
  EXPECT_EQ(one.count(), 1001U);
}

TEST(Latencies, AFailedFrameIsInfinitelyLate) {
  Latencies latencies;
  for (int i = 0; i < 98; ++i) latencies.add(10);
  latencies.add_failure();
  latencies.add_failure();
  EXPECT_EQ(latencies.percentile(98), 10);
  EXPECT_TRUE(std::isinf(latencies.percentile(99)));
  EXPECT_EQ(latencies.max(), 10) << "of the frames with a result";
  Latencies failures;
  failures.add_failure();
  EXPECT_TRUE(std::isinf(failures.percentile(50)));
}

TEST(Latencies, APercentileNeedsFiveFramesBeyondIt) {
  Latencies latencies;
  for (int i = 0; i < 499; ++i) latencies.add(1);
  EXPECT_TRUE(latencies.bears(95));
  EXPECT_FALSE(latencies.bears(99));
  latencies.add_failure();
  EXPECT_TRUE(latencies.bears(99));
  EXPECT_THAT(too_few_for(latencies), testing::ElementsAre("p99.9", "p99.99"));
  EXPECT_THAT(too_few_for(Latencies{}), testing::IsEmpty());
}

TEST(Arrivals, ConstantOnesAreEvenAndShifted) {
  Arrivals arrivals = Arrivals::constant(RateSchedule({{10, 10, 1}}), 1, 0.5);
  EXPECT_DOUBLE_EQ(arrivals.next(), 0.05);
  EXPECT_DOUBLE_EQ(arrivals.next(), 0.15);
  EXPECT_DOUBLE_EQ(arrivals.next(), 0.25);
}

TEST(Arrivals, ClientsThatShareAScheduleTakeTurns) {
  const RateSchedule schedule({{10, 10, 1}});
  Arrivals first = Arrivals::constant(schedule, 0.5, 0), second = Arrivals::constant(schedule, 0.5, 0.5);
  EXPECT_DOUBLE_EQ(first.next(), 0);
  EXPECT_DOUBLE_EQ(second.next(), 0.1);
  EXPECT_DOUBLE_EQ(first.next(), 0.2);
  EXPECT_DOUBLE_EQ(second.next(), 0.3);
}

TEST(Arrivals, FollowStepsAndRamps) {
  // 10 frames in the first second, 20 in the next one, and then ever faster: 20 t + 10 t^2.
  const RateSchedule schedule({{10, 10, 1}, {20, 20, 1}, {20, 60, 2}});
  EXPECT_DOUBLE_EQ(schedule.time_of(5), 0.5);
  EXPECT_DOUBLE_EQ(schedule.time_of(10), 1);
  EXPECT_DOUBLE_EQ(schedule.time_of(20), 1.5);
  EXPECT_DOUBLE_EQ(schedule.time_of(30 + 30), 3);
  EXPECT_DOUBLE_EQ(schedule.time_of(30 + 80), 4);
  EXPECT_DOUBLE_EQ(schedule.time_of(30 + 80 + 60), 5) << "the last rate goes on";
  const RateSchedule falling({{20, 10, 2}});
  EXPECT_DOUBLE_EQ(falling.time_of(17.5), 1);
  const RateSchedule from_nothing({{0, 10, 1}});
  EXPECT_DOUBLE_EQ(from_nothing.time_of(0), 0);
  EXPECT_DOUBLE_EQ(from_nothing.time_of(5), 1);
}

TEST(Arrivals, RecordedOnesComeAgainAfterAMeanGap) {
  const std::vector<double> times{0, 1, 4};
  Arrivals arrivals = Arrivals::recorded(times, 2, 1);
  EXPECT_DOUBLE_EQ(round_seconds(times), 6);
  EXPECT_DOUBLE_EQ(arrivals.next(), 0) << "begins at the second frame";
  EXPECT_DOUBLE_EQ(arrivals.next(), 1.5) << "twice as fast";
  EXPECT_DOUBLE_EQ(arrivals.next(), 2.5) << "the first frame of the next round";
  EXPECT_DOUBLE_EQ(arrivals.next(), 3);
}

TEST(Arrivals, PoissonOnesHaveTheRateAndTheSpreadOfAPoissonProcess) {
  constexpr int kCount = 20'000;
  const RateSchedule schedule({{50, 50, 1}});
  Arrivals arrivals = Arrivals::poisson(schedule, 1, 7);
  std::vector<double> gaps;
  double before = 0;
  for (int i = 0; i < kCount; ++i) {
    const double now = arrivals.next();
    ASSERT_GT(now, before);
    gaps.push_back(now - before);
    before = now;
  }
  const double mean = before / kCount;
  double square = 0;
  for (const double gap : gaps) square += (gap - mean) * (gap - mean);
  EXPECT_NEAR(mean, 0.02, 0.001);
  EXPECT_NEAR(std::sqrt(square / kCount), mean,
              0.05 * mean);  // the deviation of an exponential distribution is its mean
  EXPECT_EQ(Arrivals::poisson(schedule, 1, 7).next(), Arrivals::poisson(schedule, 1, 7).next());
  EXPECT_NE(Arrivals::poisson(schedule, 1, 7).next(), Arrivals::poisson(schedule, 1, 8).next());
}

Report report_with_latencies(std::initializer_list<double> latencies) {
  Report report;
  for (const double latency : latencies) report.latency.add(latency);
  report.seconds = 2;
  report.sent = 10;
  report.results = 8;
  report.finished = 8;
  report.finished_of_client = {5, 3};
  report.finished_points = 3'000'000;
  return report;
}

TEST(Objective, ComparesInItsUnit) {
  const Report report = report_with_latencies({10, 20, 30});
  for (const char* met : {"p50<20.5ms", "p50<=20.1ms", "p99>=0.03s", "max<30001us", "mean<=20ms", "fps>=4", "fps<4.5",
                          "mpoints>1.4", "errors<=20%", "least-share>=75%"}) {
    const auto objective = parse_objective(met);
    ASSERT_TRUE(objective.ok()) << objective.status();
    EXPECT_TRUE(is_met(*objective, report)) << met;
  }
  for (const char* missed : {"p50<20ms", "p99.9<30ms", "p90>1s", "fps>4", "errors<20%", "least-share>75%"}) {
    const auto objective = parse_objective(missed);
    ASSERT_TRUE(objective.ok()) << objective.status();
    EXPECT_FALSE(is_met(*objective, report)) << missed;
  }
}

TEST(Objective, OfALatencyIsMissedWhenNothingWasMeasured) {
  EXPECT_FALSE(is_met(*parse_objective("p99<50ms"), Report{}));
  EXPECT_FALSE(is_met(*parse_objective("errors<=0%"), Report{}));
}

TEST(Objective, OfALatencyIsMissedAmongFailures) {
  Report report = report_with_latencies({10, 20});
  report.latency.add_failure();
  EXPECT_TRUE(is_met(*parse_objective("p50<50ms"), report));
  for (const char* missed : {"p99<50ms", "p99>1ms", "max<50ms", "mean<50ms"}) {
    EXPECT_FALSE(is_met(*parse_objective(missed), report)) << missed;
  }
}

TEST(Objective, WrongOnesSayWhy) {
  const auto message = [](const char* text) { return std::string(parse_objective(text).status().message()); };
  EXPECT_THAT(message("p99=50ms"), testing::HasSubstr("p99<50ms"));
  EXPECT_THAT(message("p98<50ms"), testing::HasSubstr("p50, p90, p95, p99, p99.9, p99.99"));
  EXPECT_THAT(message("p99<50"), testing::HasSubstr("us, ms or s"));
  EXPECT_THAT(message("fps>10Hz"), testing::HasSubstr("no unit"));
  EXPECT_THAT(message("errors<1"), testing::HasSubstr("%"));
  for (const char* wrong : {"", "<", "p99", "p99<", "p99<ms", "p99<-1ms", "p99<nanms", "p99<1e999ms", "p99<5 0ms"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(parse_objective(wrong).status())) << wrong;
  }
}

TEST(Report, CountsErrorsByReason) {
  Report report;
  client::Outcome failed;
  failed.kind = client::OutcomeKind::kFailed;
  failed.status = absl::UnavailableError("gone");
  report.add(failed, {});
  report.add(failed, {});
  client::Outcome dropped;
  dropped.kind = client::OutcomeKind::kDropped;
  report.add(dropped, {});
  EXPECT_EQ(report.errors.at("FAILED UNAVAILABLE"), 2U);
  EXPECT_EQ(report.errors.at("DROPPED"), 1U);
  EXPECT_EQ(report.error_percent(), 100);
  EXPECT_EQ(report.dropped, 1U);
  EXPECT_EQ(report.failed(), 2U);
  EXPECT_EQ(report.latency.failed(), 2U);
}

TEST(Report, TheStagesAddUpToTheWholeTime) {
  Report report;
  client::Outcome outcome;
  outcome.kind = client::OutcomeKind::kResult;
  outcome.result.emplace();
  outcome.result->timings.queue = 3;
  outcome.result->segmentation.timings.voxels = 4;
  outcome.report.decode_ms = 1;
  report.add(outcome, {.latency_ms = 30, .since_sent_ms = 15, .total_ms = 20, .client_encode_ms = 2, .points = 100});
  double sum = 0;
  for (std::size_t i = 0; i + 1 < kStages.size(); ++i) sum += report.mean_stage_ms(i);
  EXPECT_EQ(report.mean_stage_ms(kStages.size() - 1), 20);
  EXPECT_EQ(sum, 20);
  EXPECT_EQ(report.mean_stage_ms(kStages.size() - 2), 10);  // "rest"
  EXPECT_EQ(report.latency.percentile(50), 30);
}

}  // namespace
}  // namespace segserve::bench
