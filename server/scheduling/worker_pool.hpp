#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <thread>
#include <variant>
#include <vector>

#include "server/scheduling/fair_queue.hpp"

namespace segserve::server {

/// Threads that run the jobs of all clients, with a bounded FairQueue before them. All functions may be called from any
/// thread, and none of them waits for a job, but for the destructor.
class WorkerPool {
 public:
  using Ticket = FairQueue::Ticket;

  /// At most `workers` (at least 1) jobs run. `bounds` are those of what waits and runs together.
  WorkerPool(std::size_t workers, const QueueBounds& bounds);
  /// Runs what is queued to its end.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// The bound that stands against it, if the job is not taken. Evicted jobs of other clients are told on this thread,
  /// before the return. For every job that is taken exactly one of these happens: it runs, it is evicted, it is
  /// withdrawn.
  std::variant<Ticket, Refusal> submit(JobInfo info, Job job);

  /// True if the job had not begun; then it never will, and its place, bytes and points are free.
  bool withdraw(Ticket ticket);

  std::size_t workers() const { return threads_.size(); }
  /// Jobs that wait.
  std::size_t queued() const;
  /// What waits or runs.
  QueueBounds held() const;
  /// How long a caller should wait before it tries again: until the workers have done what is there now, judged by
  /// the points of these jobs and the speed of those before; 20 ms to 10 s.
  std::chrono::milliseconds retry_delay() const;

 private:
  void run(std::size_t worker);

  mutable std::mutex mutex_;
  std::condition_variable work_or_stop_;
  FairQueue queue_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace segserve::server
