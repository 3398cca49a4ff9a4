// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/resampling.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

#include "client/bench_report/measured_run.hpp"
#include "gmock/gmock.h"
#include "test/client/bench_report/made_up_run.hpp"

namespace segserve::bench_report {
namespace {

double standard_deviation(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / n);
}

TEST(MeasuredRun, TellsQuantilesByTheNearestRankAndFailedFramesAreInfinitelyLate) {
  MeasuredRun run;
  run.latency = {{.ms = 1, .count = 90}, {.ms = 2, .count = 8}};
  run.failed = 2;
  EXPECT_EQ(run.frames(), 100);
  EXPECT_EQ(run.quantile(0.9), 1);
  EXPECT_EQ(run.quantile(0.901), 2);
  EXPECT_EQ(run.quantile(0.98), 2);
  EXPECT_TRUE(std::isinf(run.quantile(0.99)));
}

TEST(MeasuredRun, LeavesOutTheWarmUpAndWhatIsLeftOfASecond) {
  auto json = made_up_json({.seconds = 5});
  for (auto& entry : json["timeline"]) entry["t"] = entry["t"].get<double>() - 2;
  json["window"]["measured_s"] = 2.5;
  EXPECT_EQ(measured_run(json).timeline.size(), 2);
}

TEST(EffectiveFrames, AreAllFramesIfFramesAreIndependent) {
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    sum += effective_frames(measured_run(made_up_json({.seed = seed})), 0.5) / 1800;
  }
  EXPECT_GT(sum / 20, 0.75);
}

TEST(EffectiveFrames, AreFewIfSecondsDifferFromOneAnother) {
  const auto run = measured_run(made_up_json({.drift = 0.3, .memory = 0.7}));
  EXPECT_LT(effective_frames(run, 0.5), 120);
  EXPECT_GE(effective_frames(run, 0.5), 1);
}

TEST(QuantileReplicates, VaryAsTheQuantileOfIndependentFramesDoes) {
  const MadeUpRun made_up{.seed = 3, .seconds = 60, .rate = 100};
  const auto run = measured_run(made_up_json(made_up));
  Random random(1);
  const double n = effective_frames(run, 0.5);
  // The asymptotic deviation of a median: 1 / (2 f sqrt(n)), with the density f of log-normal latencies there.
  const double expected = made_up.median_ms * made_up.sigma * std::sqrt(2 * std::numbers::pi) / (2 * std::sqrt(n));
  EXPECT_NEAR(standard_deviation(quantile_replicates(run, 0.5, random)), expected, 0.1 * expected);
}

TEST(QuantileReplicates, AreInfiniteWhereFramesFailed) {
  MeasuredRun run;
  run.latency = {{.ms = 1, .count = 989}};
  run.failed = 11;
  Random random(1);
  const auto replicates = quantile_replicates(run, 0.99, random);
  const auto infinite = std::ranges::count_if(replicates, [](double ms) { return std::isinf(ms); });
  EXPECT_GT(infinite, kReplicates / 3);
  EXPECT_LT(infinite, kReplicates * 9 / 10);
}

TEST(TimelineReplicates, KeepNeighborsTogether) {
  const auto mean = [](std::span<const Interval> entries) {
    double sum = 0;
    for (const Interval& entry : entries) sum += entry.results;
    return sum / static_cast<double>(entries.size());
  };
  MeasuredRun slow;
  Random random(1);
  std::normal_distribution<double> normal;
  double level = 0;
  for (std::size_t i = 0; i < 300; ++i)
    slow.timeline.push_back({.results = 60 + (level = 0.8 * level + normal(random))});
  MeasuredRun mixed = slow;
  std::ranges::shuffle(mixed.timeline, random);
  const double of_slow = standard_deviation(timeline_replicates(slow, mean, random));
  const double of_mixed = standard_deviation(timeline_replicates(mixed, mean, random));
  // The mean of this AR(1) process varies sqrt((1 + 0.8) / (1 - 0.8)) = 3 times as much as that of independent values.
  EXPECT_GT(of_slow, 2.2 * of_mixed);
  EXPECT_LT(of_slow, 4 * of_mixed);
}

TEST(TimelineReplicates, NeedATimeline) {
  Random random(1);
  EXPECT_TRUE(timeline_replicates(
                  {}, [](auto) { return 0.0; }, random)
                  .empty());
}

}  // namespace
}  // namespace segserve::bench_report
