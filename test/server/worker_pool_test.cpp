#include "segserve/server/worker_pool.hpp"

#include <atomic>
#include <future>
#include <mutex>
#include <set>

#include "gmock/gmock.h"

namespace segserve::server {
namespace {

using namespace std::chrono_literals;

/// A job that tells when it runs and waits until it may end.
struct Gate {
  std::promise<void> begun, go;
  WorkerPool::Job job() {
    return [this](std::size_t) {
      begun.set_value();
      go.get_future().wait();
    };
  }
};

TEST(WorkerPool, RunsJobsInTheOrderOfTheirArrival) {
  std::vector<int> order;
  {
    WorkerPool pool(1, 100);
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(pool.submit([&order, i](std::size_t) { order.push_back(i); }));
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
    WorkerPool pool(3, 0);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(pool.submit([&, go](std::size_t worker) {
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
  WorkerPool pool(1, 2);
  ASSERT_TRUE(pool.submit(gate.job()));
  gate.begun.get_future().wait();
  EXPECT_TRUE(pool.submit([](std::size_t) {}));
  EXPECT_TRUE(pool.submit([](std::size_t) {}));
  EXPECT_EQ(pool.queued(), 2U);
  EXPECT_FALSE(pool.submit([](std::size_t) {}));
  gate.go.set_value();
}

TEST(WorkerPool, AWithdrawnJobNeverRunsAndFreesItsPlace) {
  Gate gate;
  std::atomic<int> ran = 0;
  {
    WorkerPool pool(1, 1);
    ASSERT_TRUE(pool.submit(gate.job()));
    gate.begun.get_future().wait();
    const auto ticket = pool.submit([&ran](std::size_t) { ran += 1; });
    ASSERT_TRUE(ticket);
    EXPECT_TRUE(pool.withdraw(*ticket));
    EXPECT_FALSE(pool.withdraw(*ticket));
    EXPECT_TRUE(pool.submit([&ran](std::size_t) { ran += 10; }));
    gate.go.set_value();
  }
  EXPECT_EQ(ran, 10);
}

TEST(WorkerPool, AJobThatHasBegunCannotBeWithdrawn) {
  Gate gate;
  WorkerPool pool(1, 1);
  const auto ticket = pool.submit(gate.job());
  gate.begun.get_future().wait();
  EXPECT_FALSE(pool.withdraw(*ticket));
  gate.go.set_value();
}

}  // namespace
}  // namespace segserve::server
