// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/scheduling/fair_queue.hpp"

namespace segserve::server {

/// The state of a pool at this moment.
struct PoolState {
  std::size_t workers = 0, busy_workers = 0;
  std::size_t waiting = 0;                   ///< jobs
  std::chrono::nanoseconds longest_wait{0};  ///< of the jobs that wait now
  QueueBounds held{}, bounds{};              ///< by waiting and running jobs together
};

/// Threads that run the jobs of all clients in the order of a bounded FairQueue. Thread-safe. Only the destructor waits
/// for jobs.
class WorkerPool {
 public:
  using Ticket = FairQueue::Ticket;

  /// An action that a worker takes, on its own thread, once it has had no job for a while. It must not throw.
  struct WhenIdle {
    std::chrono::milliseconds after;
    std::function<void(std::size_t worker)> run;
  };

  /// At most `workers` (at least 1) jobs run at the same time. `bounds` hold for waiting and running jobs together.
  WorkerPool(std::size_t workers, const QueueBounds& bounds, std::optional<WhenIdle> when_idle = std::nullopt);
  /// Runs all waiting jobs to their end.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Takes the job, or returns the bound that it would exceed. Evicted jobs of other clients learn that on this thread
  /// before the return. Exactly one of these happens to every job that was taken: it runs, it is evicted, or it is
  /// withdrawn.
  std::variant<Ticket, Refusal> submit(JobInfo info, Job job);

  /// True if the job had not begun. It never will then, and its place, bytes and points are free.
  bool withdraw(Ticket ticket);

  std::size_t workers() const { return threads_.size(); }
  PoolState state() const;
  /// Jobs that wait.
  std::size_t queued() const;
  /// The sum over waiting and running jobs.
  QueueBounds held() const;
  /// See FairQueue::expected_time.
  std::chrono::nanoseconds expected_time(const std::string& client, std::uint64_t points) const;
  /// How long a caller should wait before it tries again: until the workers have finished the present jobs, judged by
  /// the points of these and the speed of earlier ones; 20 ms to 10 s.
  std::chrono::milliseconds retry_delay() const;

 private:
  enum class Turn { kJob, kIdle, kEnd };

  void run(std::size_t worker);
  /// kIdle at the deadline, if there is one.
  Turn wait_for_turn(std::optional<std::chrono::steady_clock::time_point> idle_at,
                     std::optional<FairQueue::Started>& job);

  const std::optional<WhenIdle> when_idle_;
  mutable Mutex mutex_;
  CondVar work_or_stop_;
  FairQueue queue_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace segserve::server
