#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace segserve::server {

/// Threads that run jobs in the order of their arrival, with a bounded queue before them. All functions may
/// be called from any thread, and none of them waits for a job, but for the destructor.
class WorkerPool {
 public:
  /// A job is told which worker runs it, 0 .. workers - 1, so that it can use what that worker owns. It must
  /// not throw.
  using Job = std::function<void(std::size_t worker)>;
  using Ticket = std::uint64_t;

  /// At most `workers` (at least 1) jobs run and `max_queue` jobs wait.
  WorkerPool(std::size_t workers, std::size_t max_queue);
  /// Runs what is queued to its end.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// nullopt if all workers are busy and the queue is full.
  std::optional<Ticket> submit(Job job);

  /// True if the job had not begun; then it never will, and its place in the queue is free.
  bool withdraw(Ticket ticket);

  std::size_t workers() const { return threads_.size(); }
  /// Jobs that wait.
  std::size_t queued() const;

 private:
  struct Entry {
    Ticket ticket;
    Job job;
  };

  void run(std::size_t worker);

  const std::size_t capacity_;  // jobs that run or wait
  mutable std::mutex mutex_;
  std::condition_variable work_or_stop_;
  std::deque<Entry> queue_;
  std::size_t running_ = 0;
  Ticket next_ticket_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace segserve::server
