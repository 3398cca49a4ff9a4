// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/run_diff.hpp"

#include <cmath>
#include <string>

#include "client/bench_report/comparable.hpp"
#include "client/bench_report/run_json.hpp"
#include "gmock/gmock.h"
#include "test/client/bench_report/made_up_run.hpp"

namespace segserve::bench_report {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

const DiffRow& row_of(const RunDiff& diff, const std::string& name) {
  for (const DiffRow& row : diff.rows) {
    if (row.name == name) return row;
  }
  throw std::out_of_range(name);
}

/// The number of pairs of load tests, each with seeds of its own, in which a figure of the second one is worse.
int alarms(int pairs, MadeUpRun first, MadeUpRun second, double allow) {
  int count = 0;
  for (int i = 0; i < pairs; ++i) {
    first.seed = 1000 + 2 * static_cast<std::uint64_t>(i);
    second.seed = first.seed + 1;
    const RunDiff diff = diff_runs(made_up_json(first), made_up_json(second), {.allow = allow});
    count += worse_figures(diff).empty() ? 0 : 1;
  }
  return count;
}

TEST(MadeUpRuns, AreRuns) { EXPECT_TRUE(check_run(made_up_json({})).ok()) << check_run(made_up_json({})); }

TEST(RunDiff, EqualRunsRaiseNoAlarm) { EXPECT_EQ(alarms(200, {}, {}, 0.1), 0); }

// Nothing is allowed, so that the intervals alone decide. With 99 % for each of five figures that vary, 2.5 % of the
// pairs are expected to look worse in one of them.
TEST(RunDiff, IntervalsHoldWhatTheyPromise) { EXPECT_LE(alarms(200, {}, {}, 0), 12); }

// Seconds resemble their neighbors here, so that a run of half a minute holds no more than five independent ones, whose
// own spread is hard to tell from them.
TEST(RunDiff, EqualRunsThatWanderRaiseHardlyAnAlarm) {
  const MadeUpRun wandering{.drift = 0.12, .memory = 0.7};
  EXPECT_LE(alarms(200, wandering, wandering, 0.1), 10);
}

TEST(RunDiff, FindsLatenciesThatGrewByFifteenPercent) { EXPECT_GE(alarms(100, {}, {.median_ms = 1.15 * 30}, 0.1), 97); }

TEST(RunDiff, FindsThroughputThatFellByFifteenPercent) { EXPECT_EQ(alarms(50, {.rate = 100}, {.rate = 85}, 0.1), 50); }

TEST(RunDiff, FindsCpuThatGrewByFifteenPercent) { EXPECT_EQ(alarms(50, {}, {.cpu_ms = 1.15 * 3}, 0.1), 50); }

TEST(RunDiff, LetsPassWhatIsAllowed) { EXPECT_LE(alarms(100, {}, {.median_ms = 1.05 * 30}, 0.1), 3); }

TEST(RunDiff, TellsBetterFromWorse) {
  const RunDiff diff = diff_runs(made_up_json({.median_ms = 40}), made_up_json({.seed = 2, .median_ms = 30}), {});
  EXPECT_EQ(row_of(diff, "p50").verdict, DiffVerdict::kBetter);
  EXPECT_EQ(row_of(diff, "throughput").verdict, DiffVerdict::kSame);
  EXPECT_NEAR(row_of(diff, "p50").change, -0.25, 0.03);
  EXPECT_THAT(worse_figures(diff), IsEmpty());
}

TEST(RunDiff, IsUnclearWhereRunsAreTooShortToTell) {
  const RunDiff diff =
      diff_runs(made_up_json({.seconds = 4, .rate = 5}), made_up_json({.seed = 9, .seconds = 4, .rate = 5}), {});
  EXPECT_EQ(row_of(diff, "p99").verdict, DiffVerdict::kUnclear);
  EXPECT_THAT(to_text(diff), HasSubstr("too short, or too uneven"));
}

// Hardly two of 180 frames are slower than p99: that it is half as high says little.
TEST(RunDiff, FewFramesBeyondAPercentileDoNotJudgeIt) {
  const MadeUpRun slow{.seconds = 6, .rate = 30, .median_ms = 60},
      fast{.seed = 2, .seconds = 6, .rate = 30, .median_ms = 30};
  const RunDiff diff = diff_runs(made_up_json(slow), made_up_json(fast), {});
  EXPECT_EQ(row_of(diff, "p50").verdict, DiffVerdict::kBetter);
  EXPECT_EQ(row_of(diff, "p95").verdict, DiffVerdict::kBetter);
  EXPECT_EQ(row_of(diff, "p99").verdict, DiffVerdict::kUnclear);
}

TEST(RunDiff, FindsFramesThatFail) {
  const RunDiff diff = diff_runs(made_up_json({}), made_up_json({.seed = 2, .failed_share = 0.02}), {});
  const DiffRow& errors = row_of(diff, "errors");
  EXPECT_EQ(errors.verdict, DiffVerdict::kWorse);
  EXPECT_NEAR(errors.change, 2, 0.8);
  const DiffRow& p99 = row_of(diff, "p99");
  EXPECT_TRUE(std::isinf(p99.b));
  EXPECT_EQ(p99.verdict, DiffVerdict::kWorse);
  EXPECT_THAT(worse_figures(diff), HasSubstr("p99 by infinite"));
  EXPECT_TRUE(to_json(diff)["rows"][3]["is_infinite"].get<bool>());
}

TEST(RunDiff, IsTheSameWithTheSameSeed) {
  const auto a = made_up_json({}), b = made_up_json({.seed = 2});
  EXPECT_EQ(to_json(diff_runs(a, b, {})), to_json(diff_runs(a, b, {})));
  EXPECT_NE(to_json(diff_runs(a, b, {})), to_json(diff_runs(a, b, {.seed = 2})));
}

TEST(RunDiff, CpuOfTheServerHasNoInterval) {
  auto a = made_up_json({}), b = made_up_json({.seed = 2});
  a["server_metrics"] = {{"cpu_ms_per_frame", 20}};
  b["server_metrics"] = {{"cpu_ms_per_frame", 23}};
  const RunDiff diff = diff_runs(a, b, {});
  const DiffRow& row = row_of(diff, "CPU of the server");
  EXPECT_FALSE(row.low.has_value());
  EXPECT_EQ(row.verdict, DiffVerdict::kWorse);
}

TEST(Comparable, EqualSchedulesAre) {
  auto a = made_up_json({}), b = made_up_json({.seed = 2, .seconds = 60});
  a["command"] = {"segctl", "bench", "--clients", "1", "--server", "a:1", "--duration=30", "--json", "a.json"};
  b["command"] = {"segctl", "bench", "--clients", "1", "--server", "b:1", "--duration", "60", "--token-file", "t"};
  EXPECT_THAT(reasons_not_to_compare(a, b), IsEmpty());
}

TEST(Comparable, EachDifferenceIsNamed) {
  auto a = made_up_json({}), b = made_up_json({});
  b["codec"] = "rgbd";
  b["clients"] = 4;
  b["mpoints_per_s"] = 1.0;
  b["loop"] = "open";
  b["offered_frames_per_s"] = 30;
  b["points"] = {{{"label", "4 clients"}}, {{"label", "8 clients"}}};
  a["command"] = {"segctl", "bench", "--method", "border", "--size=640x480"};
  b["command"] = {"segctl", "bench", "--method", "lambda-convex", "--size=640x480", "--clients", "4"};
  EXPECT_THAT(reasons_not_to_compare(a, b),
              ElementsAre("loop: 'closed' and 'open'", "clients: 1 and 4", "codec: 'planar' and 'rgbd'",
                          "offered frames/s: none and 30", "schedule: [] and [\"4 clients\",\"8 clients\"]",
                          HasSubstr("points a frame: 300000 and"), "--method: border and lambda-convex"));
}

TEST(Comparable, NothingCanBeComparedWithARunWithoutResults) {
  EXPECT_THAT(reasons_not_to_compare(made_up_json({.failed_share = 1}), made_up_json({})),
              IsSupersetOf({std::string("the first load test has no result")}));
}

TEST(Comparable, OtherMachinesAndFindingsAreTold) {
  auto a = made_up_json({}), b = made_up_json({});
  a["host"] = {{"name", "x"}, {"cpus", 2}};
  b["host"] = {{"name", "y"}, {"cpus", 2}};
  b["findings"] = {{{"code", "UNSTABLE"}, {"text", "It was unstable."}}};
  EXPECT_THAT(caveats(a, b),
              ElementsAre("the machine is another one: 'x' and 'y'", "the second load test says: It was unstable."));
}

}  // namespace
}  // namespace segserve::bench_report
