// SPDX-License-Identifier: Apache-2.0
// Which runs a plan makes, with runs that the test makes up.
#include "client/load_test/plan.hpp"

#include <vector>

#include "client/load_test/fault_mix.hpp"
#include "gmock/gmock.h"

namespace segserve::bench {
namespace {

/// A run of a second with so many results, each of this latency.
LoadResult made_up(std::size_t clients, int results, double latency_ms) {
  Report report;
  report.seconds = 1;
  for (int i = 0; i < results; ++i) {
    report.add_finished(static_cast<std::size_t>(i) % clients, 10);
    ++report.sent;
    ++report.results;
    report.latency.add(latency_ms);
  }
  LoadResult result;
  result.parts = {{report}};
  result.timeline.push_back({.t = 0, .seconds = 1, .results = static_cast<std::uint64_t>(results)});
  result.window_s = 1;
  result.finished = report.finished;
  result.summarize();
  return result;
}

TEST(Plan, ASweepHasAPointForEachNumberOfClientsAndTheSumOfAll) {
  LoadPlan plan;
  plan.client_counts = {1, 2, 4};
  std::vector<std::size_t> asked;
  double cost = 0;
  plan.server_cpu_ms_per_frame = [&cost] { return ++cost; };
  const auto runs = run_plan(plan, {parse_objective("p50<35ms").value()},
                             [&](const LoadOptions& load, const LoadObserver&) {
                               asked.push_back(load.clients);
                               const auto clients = static_cast<int>(load.clients);
                               return made_up(load.clients, 10 * clients, 10.0 * clients);
                             },
                             {});
  ASSERT_TRUE(runs.ok()) << runs.status();
  EXPECT_THAT(asked, testing::ElementsAre(1, 2, 4));
  ASSERT_EQ(runs->points.size(), 3U);
  EXPECT_EQ(runs->points[1].label, "2 clients");
  EXPECT_EQ(runs->points[1].verdict, "met");
  EXPECT_EQ(runs->points[2].verdict, "missed");
  EXPECT_EQ(*runs->points[2].server_cpu_ms_per_frame, 3);
  EXPECT_EQ(runs->result.total.results, 70U);
  EXPECT_DOUBLE_EQ(runs->result.total.seconds, 3);
  EXPECT_DOUBLE_EQ(runs->result.timeline[2].t, 2) << "one run follows the other";
}

TEST(Plan, TheLeastShareOfASweepIsThatOfItsLeastFairRun) {
  LoadPlan plan;
  plan.client_counts = {1, 2, 3};
  const auto runs = run_plan(plan, {},
                             [](const LoadOptions& load, const LoadObserver&) {
                               LoadResult result = made_up(load.clients, 10, 10);
                               Report& part = result.parts.front().front();
                               part.finished = 4 * load.clients;
                               part.finished_of_client.assign(load.clients, 4);
                               if (load.clients == 2) part.finished_of_client = {3, 5};
                               result.summarize();
                               return result;
                             },
                             {});
  ASSERT_TRUE(runs.ok()) << runs.status();
  EXPECT_DOUBLE_EQ(runs->result.total.least_share_percent(), 75);
  EXPECT_TRUE(is_met(parse_objective("least-share>70%").value(), runs->result.total));
  EXPECT_TRUE(runs->result.total.finished_of_client.empty()) << "clients of different runs are not the same";
}

TEST(Plan, WindowsFollowUntilThreeInARowAgree) {
  LoadPlan plan;
  plan.client_counts = {1};
  plan.load.duration = std::chrono::seconds(1);
  plan.until_stable = 0.05;
  const auto run_with = [&plan](const std::vector<int>& rates) {
    return run_plan(plan, {},
                    [&rates](const LoadOptions& load, const LoadObserver& observer) {
                      EXPECT_EQ(load.levels.size(), kMostWindows);
                      LoadResult result;
                      std::vector<Report> levels;
                      for (const int rate : rates) {
                        result.parts.push_back(made_up(1, rate, 10).parts.front());
                        levels.push_back(result.parts.back().front());
                        if (observer.on_level(levels)) break;
                      }
                      result.summarize();
                      return result;
                    },
                    {})
        .value();
  };
  const LoadRuns settled = run_with({50, 80, 100, 102, 98, 300});
  EXPECT_EQ(settled.result.total.results, 300U) << "of the three that agree";
  EXPECT_THAT(settled.findings, testing::IsEmpty());
  const LoadRuns unsettled = run_with({100, 200, 100, 200, 100});
  ASSERT_EQ(unsettled.findings.size(), 1U);
  EXPECT_EQ(unsettled.findings[0].code, "UNSTABLE");
  EXPECT_EQ(unsettled.result.total.results, 400U) << "the last three are reported all the same";
}

TEST(FaultMix, IsReadAndItsFaultsAreToldAtOnce) {
  const auto mix = parse_fault_mix("vanish=1%,slow-reader=2,cancel=0.5%");
  ASSERT_TRUE(mix.ok()) << mix.status();
  EXPECT_EQ(mix->slow_readers, 2U);
  EXPECT_DOUBLE_EQ(mix->vanish, 0.01);
  EXPECT_DOUBLE_EQ(mix->cancel, 0.005);
  EXPECT_EQ(mix->malformed, 0);
  const auto wrong = parse_fault_mix("vanish=1,slow-reader=x,melt=1%,cancel=101%");
  for (const char* word : {"vanish=PERCENT%", "slow-reader=NUMBER", "'melt' is none of", "cancel=PERCENT%"}) {
    EXPECT_THAT(wrong.status().message(), testing::HasSubstr(word));
  }
  for (const char* text : {"", ",", "vanish", "vanish=", "vanish=nan%", "slow-reader=-1", "slow-reader=101"}) {
    EXPECT_FALSE(parse_fault_mix(text).ok()) << text;
  }
}

}  // namespace
}  // namespace segserve::bench
