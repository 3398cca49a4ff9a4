#include "server/scheduling/worker_pool.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace segserve::server {

WorkerPool::WorkerPool(std::size_t workers, const QueueBounds& bounds) : queue_(bounds) {
  threads_.reserve(workers);
  for (std::size_t worker = 0; worker < workers; ++worker) {
    threads_.emplace_back([this, worker] { run(worker); });
  }
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_or_stop_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::variant<WorkerPool::Ticket, Refusal> WorkerPool::submit(JobInfo info, Job job) {
  FairQueue::Pushed pushed;
  {
    const std::lock_guard lock(mutex_);
    pushed = queue_.push(std::move(info), std::move(job));
  }
  if (std::holds_alternative<Ticket>(pushed.result)) work_or_stop_.notify_one();
  for (const Job& evicted : pushed.evicted) evicted.evicted();
  return pushed.result;
}

bool WorkerPool::withdraw(Ticket ticket) {
  std::optional<Job> job;  // ends, with all it keeps, after the lock is gone
  const std::lock_guard lock(mutex_);
  job = queue_.withdraw(ticket);
  return job.has_value();
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard lock(mutex_);
  return queue_.waiting();
}

QueueBounds WorkerPool::held() const {
  const std::lock_guard lock(mutex_);
  return queue_.held();
}

std::chrono::milliseconds WorkerPool::retry_delay() const {
  using std::chrono::milliseconds;
  const std::lock_guard lock(mutex_);
  const auto delay = std::chrono::duration_cast<milliseconds>(queue_.backlog()) / threads_.size();
  return std::clamp<milliseconds>(delay, milliseconds(20), milliseconds(10'000));
}

void WorkerPool::run(std::size_t worker) {
  std::unique_lock lock(mutex_);
  while (true) {
    work_or_stop_.wait(lock, [this] { return stopping_ || queue_.waiting() > 0; });
    std::optional<FairQueue::Started> started = queue_.start_next();
    if (!started) return;
    lock.unlock();
    const auto begin = std::chrono::steady_clock::now();
    started->job.run(worker);
    started->job = {};  // frees what the job keeps before its place is free
    const auto took = std::chrono::steady_clock::now() - begin;
    lock.lock();
    queue_.finish(started->ticket, took);
  }
}

}  // namespace segserve::server
