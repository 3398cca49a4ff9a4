// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/fair_queue.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gmock/gmock.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using Ticket = FairQueue::Ticket;

constexpr QueueBounds kWide{.jobs = 1'000'000, .bytes = 1'000'000'000, .points = 1'000'000'000'000};

Job nothing() {
  return {.run = [](std::size_t) {}};
}
Job evictable() {
  return {.run = [](std::size_t) {}, .evicted = [] {}};
}

Ticket must_push(FairQueue& queue, JobInfo info, Job job = nothing()) {
  const FairQueue::Pushed pushed = queue.push(std::move(info), std::move(job));
  EXPECT_TRUE(std::holds_alternative<Ticket>(pushed.result));
  return std::get<Ticket>(pushed.result);
}

/// The load that a client makes. It keeps `window` jobs in the queue, each of which takes `time` on a worker and claims
/// to have `points`.
struct Load {
  std::string client;
  std::size_t window;
  std::uint64_t points;
  std::chrono::nanoseconds time;
  std::size_t one_job_clients = 0;  ///< if above 0, each job comes from a new client
};

/// Simulates workers that take what the queue gives them. Returns how long they worked for each load.
std::vector<std::chrono::nanoseconds> simulate(const std::vector<Load>& loads, std::size_t workers,
                                               std::chrono::nanoseconds duration) {
  FairQueue queue(kWide);
  std::map<Ticket, std::size_t> load_of;
  std::vector<std::chrono::nanoseconds> got(loads.size(), 0ns);
  std::size_t newcomers = 0;
  const auto push = [&](std::size_t load) {
    std::string client = loads[load].client;
    if (loads[load].one_job_clients > 0) client += std::to_string(++newcomers);
    load_of[must_push(queue, {.client = client, .points = loads[load].points})] = load;
  };
  for (std::size_t load = 0; load < loads.size(); ++load) {
    for (std::size_t i = 0; i < loads[load].window; ++i) push(load);
  }
  std::multimap<std::chrono::nanoseconds, Ticket> busy;  // by the time of their end
  std::chrono::nanoseconds now = 0ns;
  while (now < duration) {
    while (busy.size() < workers) {
      const auto started = queue.start_next();
      if (!started) break;
      busy.emplace(now + loads[load_of[started->ticket]].time, started->ticket);
    }
    const auto [end, ticket] = *busy.begin();
    busy.erase(busy.begin());
    now = end;
    const std::size_t load = load_of[ticket];
    got[load] += loads[load].time;
    queue.finish(ticket, loads[load].time);
    push(load);
  }
  EXPECT_LT(queue.clients(), 1000U) << "clients that are gone are forgotten";
  return got;
}

/// Starts all jobs, one after the other, and returns their tickets in this order.
std::vector<Ticket> start_all(FairQueue& queue) {
  std::vector<Ticket> order;
  while (const auto started = queue.start_next()) {
    order.push_back(started->ticket);
    queue.finish(started->ticket, 1ms);
  }
  return order;
}

TEST(FairQueue, FlowsOfAClientTakeTurnsByTheirPoints) {
  FairQueue queue(kWide);
  const auto push = [&queue](const char* flow, std::uint64_t points) {
    return must_push(queue, {.client = "c", .flow = flow, .points = points});
  };
  const Ticket a = push("busy", 100'000), b = push("busy", 100'000), c = push("busy", 100'000);
  const Ticket d = push("small", 10'000), e = push("small", 10'000), f = push("late", 10'000);
  EXPECT_THAT(start_all(queue), ElementsAre(a, d, f, e, b, c));
}

TEST(FairQueue, AFlowSavesNothingWhileItIsAway) {
  FairQueue queue(kWide);
  const auto push = [&queue](const char* flow) {
    return must_push(queue, {.client = "c", .flow = flow, .points = 10'000});
  };
  for (int i = 0; i < 100; ++i) push("present");
  EXPECT_EQ(start_all(queue).size(), 100U);
  std::vector<Ticket> absent;
  for (int i = 0; i < 6; ++i) {
    push("present");
    absent.push_back(push("absent"));
  }
  std::vector<Ticket> order = start_all(queue);
  EXPECT_EQ(order.front(), absent.front());
  order.resize(6);
  const auto its = std::ranges::count_if(order, [&](Ticket t) { return std::ranges::find(absent, t) != absent.end(); });
  EXPECT_GE(its, 3);
  EXPECT_LE(its, 4);
}

TEST(FairQueue, PrioritiesOfAClientGoBeforeItsFlows) {
  FairQueue queue(kWide);
  const Ticket a = must_push(queue, {.client = "c", .flow = "1", .priority = 1});
  const Ticket b = must_push(queue, {.client = "c", .flow = "1", .priority = 1});
  const Ticket c = must_push(queue, {.client = "c", .flow = "2", .priority = 0});
  EXPECT_THAT(start_all(queue), ElementsAre(a, b, c));
}

TEST(FairQueue, AClientOfManyFlowsHasThePartOfOneClient) {
  FairQueue queue(kWide);
  for (int flow = 0; flow < 50; ++flow) {
    must_push(queue, {.client = "many", .flow = std::to_string(flow), .points = 10'000});
  }
  std::vector<Ticket> one;
  for (int i = 0; i < 5; ++i) one.push_back(must_push(queue, {.client = "one", .points = 10'000}));
  std::vector<Ticket> order = start_all(queue);
  order.resize(10);
  for (const Ticket ticket : one) EXPECT_THAT(order, testing::Contains(ticket));
}

TEST(FairQueue, JobsOfOneClientComeByPriorityThenByArrival) {
  FairQueue queue(kWide);
  const Ticket a = must_push(queue, {.client = "c", .priority = 0});
  const Ticket b = must_push(queue, {.client = "c", .priority = 7});
  const Ticket c = must_push(queue, {.client = "c", .priority = std::numeric_limits<std::int32_t>::min()});
  const Ticket d = must_push(queue, {.client = "c", .priority = 7});
  const Ticket e = must_push(queue, {.client = "c", .priority = 0});
  std::vector<Ticket> order;
  while (const auto started = queue.start_next()) order.push_back(started->ticket);
  EXPECT_THAT(order, ElementsAre(b, d, a, e, c));
}

TEST(FairQueue, PrioritiesDoNotReachAcrossClients) {
  FairQueue queue(kWide);
  std::map<Ticket, std::string> client_of;
  for (int i = 0; i < 3; ++i)
    client_of[must_push(queue, {.client = "urgent", .priority = 9, .points = 100})] = "urgent";
  for (int i = 0; i < 3; ++i)
    client_of[must_push(queue, {.client = "patient", .priority = -9, .points = 100})] = "patient";
  std::vector<std::string> order;
  while (const auto started = queue.start_next()) {
    order.push_back(client_of[started->ticket]);
    queue.finish(started->ticket, 1ms);
  }
  EXPECT_THAT(order, ElementsAre("urgent", "patient", "urgent", "patient", "urgent", "patient"));
}

TEST(FairQueue, ManyJobsGetAClientNoMoreThanItsShare) {
  const auto got = simulate({{"greedy", 60, 300'000, 80ms}, {"modest", 2, 300'000, 80ms}}, 1, 100s);
  EXPECT_NEAR(got[0] / 1ms, got[1] / 1ms, 200);
}

TEST(FairQueue, LargeCloudsGetAClientNoMoreThanItsShare) {
  for (const std::size_t workers : {1, 2, 3}) {
    const auto got = simulate({{"large", 8, 10'000'000, 2500ms}, {"small", 8, 10'000, 3ms}}, workers, 1000s);
    EXPECT_NEAR(static_cast<double>(got[0] / 1ms), static_cast<double>(got[1] / 1ms), 0.02 * 1000'000) << workers;
  }
}

TEST(FairQueue, CostlyOptionsGetAClientNoMoreThanItsShare) {
  const auto got = simulate({{"costly", 4, 300'000, 900ms}, {"cheap", 4, 300'000, 60ms}}, 2, 1000s);
  EXPECT_NEAR(static_cast<double>(got[0] / 1ms), static_cast<double>(got[1] / 1ms), 0.02 * 1000'000);
}

TEST(FairQueue, NobodyGetsLessThanHalfOfTheFairShareAmongMixedLoads) {
  std::vector<Load> loads;
  for (int i = 0; i < 32; ++i) {
    const auto scale = 1U << static_cast<unsigned>(i % 8);  // clouds of 10,000 to 1,280,000 points
    loads.push_back({"client " + std::to_string(i), 1 + static_cast<std::size_t>(i % 5), 10'000U * scale, 2ms * scale});
  }
  const auto got = simulate(loads, 2, 600s);
  const std::chrono::nanoseconds fair = 2 * 600s / 32;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    // A client that keeps only one job has none in the queue at the moment when one of its jobs ends.
    EXPECT_GT(got[i], fair / 2) << loads[i].client;
    EXPECT_LT(got[i], fair * 2) << loads[i].client;
  }
}

TEST(FairQueue, ClientsThatComeForOneJobDoNotStarveTheOneThatStays) {
  // There are 20 newcomers at any time. Each has the same right to the workers as the client that stays.
  const auto got = simulate({{"stays", 4, 300'000, 80ms}, {"newcomer ", 20, 300'000, 80ms, 1}}, 1, 1000s);
  EXPECT_GT(got[0], 1000s / 21 / 2);
  EXPECT_LT(got[0], 1000s / 21 * 2);
}

TEST(FairQueue, AClientGetsNothingForTheTimeItWasAway) {
  FairQueue queue(kWide);
  for (int i = 0; i < 1000; ++i) {
    must_push(queue, {.client = "stays", .points = 1000});
    queue.finish(queue.start_next()->ticket, 1ms);
  }
  std::map<Ticket, std::string> client_of;
  for (int i = 0; i < 10; ++i) {
    client_of[must_push(queue, {.client = "stays", .points = 1000})] = "stays";
    client_of[must_push(queue, {.client = "returns", .points = 1000})] = "returns";
  }
  int stays = 0;
  for (int i = 0; i < 10; ++i) {
    const auto started = queue.start_next();
    stays += client_of[started->ticket] == "stays" ? 1 : 0;
    queue.finish(started->ticket, 1ms);
  }
  EXPECT_NEAR(stays, 5, 1);
}

TEST(FairQueue, NoWorkerLeadsToDebtsThatStarveLater) {
  // One client cannot use its share of 8 workers, and another takes the rest. Then a third client comes.
  FairQueue queue(kWide);
  std::map<Ticket, char> client_of;
  std::multimap<std::chrono::nanoseconds, Ticket> busy;
  const auto push = [&](char client) {
    client_of[must_push(queue, {.client = std::string(1, client), .points = 1000})] = client;
  };
  push('a');
  for (int i = 0; i < 20; ++i) push('b');
  std::map<char, int> done;
  std::chrono::nanoseconds now = 0ns;
  while (now < 200s) {
    while (busy.size() < 8) {
      const auto started = queue.start_next();
      busy.emplace(now + 10ms, started->ticket);
    }
    now = busy.begin()->first;
    const Ticket ticket = busy.begin()->second;
    busy.erase(busy.begin());
    queue.finish(ticket, 10ms);
    push(client_of[ticket]);
    if (now >= 100s && done.empty()) {
      for (int i = 0; i < 20; ++i) push('c');
    }
    if (now >= 100s) ++done[client_of[ticket]];
  }
  EXPECT_NEAR(done['b'], done['c'], 0.02 * done['c']);
  EXPECT_NEAR(done['a'], 10'000, 100);
}

TEST(FairQueue, RefusesBeyondEachBoundAndNamesIt) {
  using Bound = Refusal::Bound;
  const auto refused = [](FairQueue& queue, JobInfo info) {
    return std::get<Refusal>(queue.push(std::move(info), nothing()).result);
  };
  FairQueue queue({.jobs = 3, .bytes = 100, .points = 1000});
  must_push(queue, {.client = "c", .points = 400, .bytes = 60});
  const Refusal bytes = refused(queue, {.client = "c", .points = 1, .bytes = 41});
  EXPECT_EQ(bytes.bound, Bound::kBytes);
  EXPECT_EQ(bytes.allowed, 100U);
  EXPECT_EQ(bytes.actual, 101U);
  const Refusal points = refused(queue, {.client = "c", .points = 601, .bytes = 40});
  EXPECT_EQ(points.bound, Bound::kPoints);
  EXPECT_EQ(points.allowed, 1000U);
  EXPECT_EQ(points.actual, 1001U);
  must_push(queue, {.client = "c", .points = 600, .bytes = 40});
  must_push(queue, {.client = "c"});
  const Refusal jobs = refused(queue, {.client = "c"});
  EXPECT_EQ(jobs.bound, Bound::kJobs);
  EXPECT_EQ(jobs.allowed, 3U);
  EXPECT_EQ(jobs.actual, 4U);
  EXPECT_EQ(refused(queue, {.client = "d", .bytes = ~std::uint64_t{0}}).bound, Bound::kJobs);
}

TEST(FairQueue, AJobThatMayExceedTheBoundsIsTakenAndCounts) {
  FairQueue queue({.jobs = 1, .bytes = 100, .points = 100});
  must_push(queue, {.client = "c", .bytes = 90}, evictable());
  const FairQueue::Pushed pushed = queue.push({.client = "d", .bytes = 90, .may_exceed_bounds = true}, nothing());
  EXPECT_TRUE(std::holds_alternative<Ticket>(pushed.result));
  EXPECT_TRUE(pushed.evicted.empty());
  EXPECT_EQ(queue.held().bytes, 180U);
  queue.finish(queue.start_next()->ticket, 1ms);
  EXPECT_TRUE(std::holds_alternative<Refusal>(queue.push({.client = "c"}, nothing()).result));
  queue.finish(queue.start_next()->ticket, 1ms);
  must_push(queue, {.client = "c", .bytes = 100});
}

TEST(FairQueue, CountsOfAnySizeDoNotOverflow) {
  FairQueue queue({.jobs = 3, .bytes = 100, .points = 100});
  must_push(queue, {.client = "c", .points = 1, .bytes = 1});
  constexpr std::uint64_t kMost = ~std::uint64_t{0};
  EXPECT_TRUE(std::holds_alternative<Refusal>(queue.push({.client = "c", .bytes = kMost}, nothing()).result));
  EXPECT_TRUE(std::holds_alternative<Refusal>(queue.push({.client = "c", .points = kMost}, nothing()).result));
  EXPECT_EQ(queue.waiting(), 1U);
}

TEST(FairQueue, WhatRunsCountsUntilItEnds) {
  FairQueue queue({.jobs = 1, .bytes = 100, .points = 100});
  must_push(queue, {.client = "c", .points = 100, .bytes = 100});
  const auto started = queue.start_next();
  EXPECT_EQ(queue.waiting(), 0U);
  EXPECT_TRUE(std::holds_alternative<Refusal>(queue.push({.client = "d"}, nothing()).result));
  queue.finish(started->ticket, 1ms);
  EXPECT_EQ(queue.held().jobs, 0U);
  EXPECT_EQ(queue.held().bytes, 0U);
  EXPECT_EQ(queue.held().points, 0U);
  must_push(queue, {.client = "d", .points = 100, .bytes = 100});
}

TEST(FairQueue, AWithdrawnJobFreesWhatItKeptAtOnce) {
  FairQueue queue({.jobs = 2, .bytes = 100, .points = 100});
  auto kept = std::make_shared<int>(0);
  const Ticket ticket =
      must_push(queue, {.client = "c", .points = 100, .bytes = 100}, {.run = [kept](std::size_t) { ++*kept; }});
  EXPECT_EQ(kept.use_count(), 2);
  EXPECT_TRUE(queue.withdraw(ticket).has_value());
  EXPECT_EQ(kept.use_count(), 1);
  EXPECT_FALSE(queue.withdraw(ticket).has_value());
  EXPECT_EQ(queue.held().bytes, 0U);
  EXPECT_FALSE(queue.start_next().has_value());
  must_push(queue, {.client = "d", .points = 100, .bytes = 100});
}

TEST(FairQueue, AJobThatHasBegunCannotBeWithdrawn) {
  FairQueue queue(kWide);
  const Ticket ticket = must_push(queue, {.client = "c"});
  EXPECT_EQ(queue.start_next()->ticket, ticket);
  EXPECT_FALSE(queue.withdraw(ticket).has_value());
}

TEST(FairQueue, TheLeastUrgentJobOfTheClientWithMostMakesWay) {
  FairQueue queue({.jobs = 5, .bytes = 1000, .points = 1000});
  std::vector<std::string> evicted;
  const auto job = [&](const std::string& name) {
    return Job{.run = [](std::size_t) {}, .evicted = [&evicted, name] { evicted.push_back(name); }};
  };
  const auto push = [&](JobInfo info, const std::string& name) {
    FairQueue::Pushed pushed = queue.push(std::move(info), job(name));
    for (const Job& victim : pushed.evicted) victim.evicted();
    return std::holds_alternative<Ticket>(pushed.result);
  };
  EXPECT_TRUE(push({.client = "two"}, "two.1"));
  EXPECT_TRUE(push({.client = "three", .priority = 1}, "three.1"));
  EXPECT_TRUE(push({.client = "three", .priority = 0}, "three.2"));
  EXPECT_TRUE(push({.client = "three", .priority = 1}, "three.3"));
  EXPECT_TRUE(push({.client = "two"}, "two.2"));
  EXPECT_TRUE(push({.client = "new"}, "new.1"));
  EXPECT_THAT(evicted, ElementsAre("three.2"));
  EXPECT_FALSE(push({.client = "new"}, "new.2")) << "nobody has more than the newcomer would have";
  EXPECT_FALSE(push({.client = "three"}, "three.4"));
  EXPECT_TRUE(push({.client = "newer"}, "newer.1"));
  EXPECT_EQ(evicted.size(), 2U);
  EXPECT_EQ(queue.waiting(), 5U);
}

TEST(FairQueue, AsManyMakeWayAsNeededOrNone) {
  FairQueue queue({.jobs = 100, .bytes = 100, .points = 1000});
  for (int i = 0; i < 10; ++i) must_push(queue, {.client = "hog", .bytes = 10}, evictable());
  EXPECT_EQ(queue.push({.client = "new", .bytes = 35}, evictable()).evicted.size(), 4U);
  EXPECT_EQ(queue.held().bytes, 95U);
  const FairQueue::Pushed refused = queue.push({.client = "newer", .bytes = 60}, evictable());
  EXPECT_TRUE(std::holds_alternative<Refusal>(refused.result)) << "it would have more than it leaves to the others";
  EXPECT_TRUE(refused.evicted.empty());
  EXPECT_EQ(queue.held().bytes, 95U);
}

TEST(FairQueue, JobsThatRunOrAreSettledStay) {
  FairQueue queue({.jobs = 3, .bytes = 100, .points = 1000});
  must_push(queue, {.client = "hog"}, evictable());
  ASSERT_TRUE(queue.start_next().has_value());
  const Ticket settled = must_push(queue, {.client = "hog"}, nothing());
  must_push(queue, {.client = "hog"}, evictable());
  EXPECT_EQ(queue.push({.client = "new"}, evictable()).evicted.size(), 1U);
  EXPECT_TRUE(queue.push({.client = "newer"}, evictable()).evicted.empty());
  EXPECT_EQ(queue.waiting(), 2U);
  EXPECT_TRUE(queue.withdraw(settled).has_value());
}

TEST(FairQueue, TheBacklogFollowsThePointsAndTheSpeed) {
  FairQueue queue(kWide);
  EXPECT_EQ(queue.backlog(), 0ns);
  for (int i = 0; i < 200; ++i) {
    must_push(queue, {.client = "c", .points = 999'000});
    queue.finish(queue.start_next()->ticket, 500ms);  // 500 ns per point; the job as such counts as 1000 points
  }
  must_push(queue, {.client = "c", .points = 1'999'000});
  must_push(queue, {.client = "d", .points = 999'000});
  EXPECT_NEAR(static_cast<double>(queue.backlog() / 1us), 1.5e6, 1e3);
}

TEST(FairQueue, ExpectsOfAClientWhatItsJobsTook) {
  FairQueue queue(kWide);
  const auto run = [&queue](const char* client, std::chrono::nanoseconds took) {
    must_push(queue, {.client = client, .points = 99'000});
    queue.finish(queue.start_next()->ticket, took);
  };
  EXPECT_EQ(queue.expected_time("slow", 99'000), 0ns) << "nothing is known yet";
  for (int i = 0; i < 100; ++i) run("slow", 100ms);
  EXPECT_NEAR(static_cast<double>(queue.expected_time("slow", 49'000) / 1us), 50'000, 500);
  EXPECT_NEAR(static_cast<double>(queue.expected_time("slow", 1'999'000) / 1us), 100'000, 1'000)
      << "a larger one may take longer, but nothing has shown that yet";
  must_push(queue, {.client = "fast", .points = 99'000});
  EXPECT_EQ(queue.expected_time("fast", 99'000), 0ns) << "what others need says nothing about it";
  queue.finish(queue.start_next()->ticket, 10ms);
  run("slow", 1us);
  EXPECT_GT(queue.expected_time("slow", 99'000), 98ms) << "it was too late, and not computed";
  for (int i = 0; i < 500; ++i) run("slow", 1us);
  EXPECT_LT(queue.expected_time("slow", 99'000), 1ms) << "one of them has to be tried again";
}

}  // namespace
}  // namespace segserve::server
