// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/worker_pool.hpp"

#include <atomic>
#include <future>
#include <mutex>
#include <set>
#include <thread>

#include "gmock/gmock.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;

/// Makes a job that says when it runs and waits until it may end.
struct Gate {
  std::promise<void> begun, go;
  std::function<void(std::size_t)> job() {
    return [this](std::size_t) {
      begun.set_value();
      go.get_future().wait();
    };
  }
};

QueueBounds at_most(std::uint64_t jobs) { return {.jobs = jobs, .bytes = 1000, .points = 1000}; }

/// True if the pool takes the job.
bool submit(WorkerPool& pool, std::function<void(std::size_t)> job) {
  return std::holds_alternative<WorkerPool::Ticket>(pool.submit({.client = "c"}, {.run = std::move(job)}));
}

TEST(WorkerPool, RunsJobsInTheOrderOfTheirArrival) {
  std::vector<int> order;
  {
    WorkerPool pool(1, at_most(101));
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(submit(pool, [&order, i](std::size_t) { order.push_back(i); }));
  }
  std::vector<int> expected(50);
  for (int i = 0; i < 50; ++i) expected[static_cast<std::size_t>(i)] = i;
  EXPECT_EQ(order, expected);
}

TEST(WorkerPool, RunsAsManyJobsAtOnceAsItHasWorkers) {
  std::mutex mutex;
  std::set<std::size_t> workers;
  std::promise<void> all_here;
  std::shared_future<void> go = all_here.get_future().share();
  {
    WorkerPool pool(3, at_most(3));
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(submit(pool, [&, go](std::size_t worker) {
        {
          const std::lock_guard lock(mutex);
          workers.insert(worker);
          if (workers.size() == 3) all_here.set_value();
        }
        EXPECT_EQ(go.wait_for(10s), std::future_status::ready);
      }));
    }
  }
  EXPECT_THAT(workers, testing::ElementsAre(0, 1, 2));
}

TEST(WorkerPool, RefusesWhatItsQueueCannotHold) {
  Gate gate;
  WorkerPool pool(1, at_most(3));
  ASSERT_TRUE(submit(pool, gate.job()));
  gate.begun.get_future().wait();
  EXPECT_TRUE(submit(pool, [](std::size_t) {}));
  EXPECT_TRUE(submit(pool, [](std::size_t) {}));
  EXPECT_EQ(pool.queued(), 2U);
  EXPECT_FALSE(submit(pool, [](std::size_t) {}));
  gate.go.set_value();
}

TEST(WorkerPool, TellsWhatItDoes) {
  Gate gate;
  WorkerPool pool(2, at_most(5));
  ASSERT_TRUE(submit(pool, gate.job()));
  gate.begun.get_future().wait();
  EXPECT_EQ(pool.state().longest_wait, 0ns);
  Gate second;
  ASSERT_TRUE(submit(pool, second.job()));
  second.begun.get_future().wait();
  ASSERT_TRUE(submit(pool, [](std::size_t) {}));
  std::this_thread::sleep_for(2ms);
  ASSERT_TRUE(submit(pool, [](std::size_t) {}));
  const PoolState state = pool.state();
  EXPECT_EQ(state.workers, 2U);
  EXPECT_EQ(state.busy_workers, 2U);
  EXPECT_EQ(state.waiting, 2U);
  EXPECT_GE(state.longest_wait, 2ms) << "that of the older job";
  EXPECT_EQ(state.held.jobs, 4U);
  EXPECT_EQ(state.bounds.jobs, 5U);
  gate.go.set_value();
  second.go.set_value();
}

TEST(WorkerPool, AWithdrawnJobNeverRunsAndFreesItsPlace) {
  Gate gate;
  std::atomic<int> ran = 0;
  {
    WorkerPool pool(1, at_most(2));
    ASSERT_TRUE(submit(pool, gate.job()));
    gate.begun.get_future().wait();
    const auto ticket = std::get<WorkerPool::Ticket>(
        pool.submit({.client = "c", .bytes = 900}, {.run = [&ran](std::size_t) { ran += 1; }}));
    EXPECT_EQ(pool.held().bytes, 900U);
    EXPECT_TRUE(pool.withdraw(ticket));
    EXPECT_FALSE(pool.withdraw(ticket));
    EXPECT_EQ(pool.held().bytes, 0U);
    EXPECT_TRUE(submit(pool, [&ran](std::size_t) { ran += 10; }));
    gate.go.set_value();
  }
  EXPECT_EQ(ran, 10);
}

TEST(WorkerPool, AJobThatHasBegunCannotBeWithdrawn) {
  Gate gate;
  WorkerPool pool(1, at_most(2));
  const auto ticket = std::get<WorkerPool::Ticket>(pool.submit({.client = "c"}, {.run = gate.job()}));
  gate.begun.get_future().wait();
  EXPECT_FALSE(pool.withdraw(ticket));
  gate.go.set_value();
}

TEST(WorkerPool, AnEvictedJobIsToldAndNeverRuns) {
  Gate gate;
  int ran = 0, evicted = 0;
  {
    WorkerPool pool(1, at_most(3));
    ASSERT_TRUE(submit(pool, gate.job()));
    gate.begun.get_future().wait();
    for (int i = 0; i < 2; ++i) {
      const auto submitted =
          pool.submit({.client = "hog"}, {.run = [&ran](std::size_t) { ++ran; }, .evicted = [&evicted] { ++evicted; }});
      ASSERT_TRUE(std::holds_alternative<WorkerPool::Ticket>(submitted));
    }
    const auto submitted = pool.submit({.client = "new"}, {.run = [&ran](std::size_t) { ran += 10; }});
    EXPECT_TRUE(std::holds_alternative<WorkerPool::Ticket>(submitted));
    EXPECT_EQ(evicted, 1);
    EXPECT_EQ(pool.queued(), 2U);
    gate.go.set_value();
  }
  EXPECT_EQ(ran, 11);
  EXPECT_EQ(evicted, 1);
}

TEST(WorkerPool, TheRetryDelayGrowsWithWhatWaitsWithinItsRange) {
  Gate gate;
  WorkerPool pool(1, {.jobs = 10, .bytes = 0, .points = ~std::uint64_t{0}});
  EXPECT_EQ(pool.retry_delay(), 20ms);
  ASSERT_TRUE(submit(pool, gate.job()));
  gate.begun.get_future().wait();
  const auto wait = [&pool](std::uint64_t points) {
    EXPECT_EQ(pool.submit({.client = "c", .points = points}, {.run = [](std::size_t) {}}).index(), 0U);
    return pool.retry_delay();
  };
  const auto some = wait(1'000'000);
  const auto more = wait(1'000'000);
  EXPECT_GT(some, 20ms);
  EXPECT_GT(more, some);
  EXPECT_LT(more, 10s);
  EXPECT_EQ(wait(1'000'000'000), 10s);
  gate.go.set_value();
}

/// Many threads submit and withdraw jobs at once, also under ThreadSanitizer. Every job that was taken must end in
/// exactly one way.
TEST(WorkerPool, EveryJobEndsOnceWhateverThreadsDo) {
  std::atomic<int> taken = 0, ran = 0, evicted = 0, withdrawn = 0;
  {
    WorkerPool pool(3, at_most(8));
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&, client = std::to_string(t)] {
        for (int i = 0; i < 500; ++i) {
          const auto submitted =
              pool.submit({.client = client, .priority = i % 3, .bytes = 10},
                          {.run = [&ran](std::size_t) { ++ran; }, .evicted = [&evicted] { ++evicted; }});
          const auto* ticket = std::get_if<WorkerPool::Ticket>(&submitted);
          if (ticket == nullptr) continue;
          ++taken;
          if (i % 2 == 0 && pool.withdraw(*ticket)) ++withdrawn;
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  EXPECT_EQ(taken, ran + evicted + withdrawn);
  EXPECT_GT(ran, 0);
}

TEST(WorkerPool, AWorkerThatHasHadNoJobForAWhileSaysSoOnce) {
  std::atomic<int> idle{0};
  WorkerPool pool(2, at_most(2), WorkerPool::WhenIdle{20ms, [&idle](std::size_t) { ++idle; }});
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(idle, 0) << "it keeps nothing before its first job";
  for (int jobs = 1; jobs <= 2; ++jobs) {
    EXPECT_TRUE(submit(pool, [](std::size_t) {}));
    for (int i = 0; i < 1000 && idle < jobs; ++i) std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(100ms);
    EXPECT_EQ(idle, jobs);
  }
}

}  // namespace
}  // namespace segserve::server
