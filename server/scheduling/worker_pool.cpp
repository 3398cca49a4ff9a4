// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/worker_pool.hpp"

#include <algorithm>
#include <utility>

namespace segserve::server {

WorkerPool::WorkerPool(std::size_t workers, const QueueBounds& bounds, std::optional<WhenIdle> when_idle)
    : when_idle_(std::move(when_idle)), queue_(bounds) {
  threads_.reserve(workers);
  for (std::size_t worker = 0; worker < workers; ++worker) {
    threads_.emplace_back([this, worker] { run(worker); });
  }
}

WorkerPool::~WorkerPool() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    work_or_stop_.notify_all();
  }
  for (std::thread& thread : threads_) thread.join();
}

std::variant<WorkerPool::Ticket, Refusal> WorkerPool::submit(JobInfo info, Job job) {
  info.since = std::chrono::steady_clock::now();
  FairQueue::Pushed pushed;
  {
    const MutexLock lock(mutex_);
    pushed = queue_.push(std::move(info), std::move(job));
    if (std::holds_alternative<Ticket>(pushed.result)) work_or_stop_.notify_one();
  }
  for (const Job& evicted : pushed.evicted) evicted.evicted();
  return pushed.result;
}

bool WorkerPool::withdraw(Ticket ticket) {
  std::optional<Job> job;  // is destroyed, with all that it keeps, after the lock is released
  const MutexLock lock(mutex_);
  job = queue_.withdraw(ticket);
  return job.has_value();
}

PoolState WorkerPool::state() const {
  const MutexLock lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  return {.workers = threads_.size(),
          .busy_workers = static_cast<std::size_t>(queue_.held().jobs) - queue_.waiting(),
          .waiting = queue_.waiting(),
          .longest_wait = now - queue_.waiting_since().value_or(now),
          .held = queue_.held(),
          .bounds = queue_.bounds()};
}

std::size_t WorkerPool::queued() const {
  const MutexLock lock(mutex_);
  return queue_.waiting();
}

QueueBounds WorkerPool::held() const {
  const MutexLock lock(mutex_);
  return queue_.held();
}

std::chrono::nanoseconds WorkerPool::expected_time(const std::string& client, std::uint64_t points) const {
  const MutexLock lock(mutex_);
  return queue_.expected_time(client, points);
}

std::chrono::milliseconds WorkerPool::retry_delay() const {
  using std::chrono::milliseconds;
  const MutexLock lock(mutex_);
  const auto delay = std::chrono::duration_cast<milliseconds>(queue_.backlog()) / threads_.size();
  return std::clamp<milliseconds>(delay, milliseconds(20), milliseconds(10'000));
}

void WorkerPool::run(std::size_t worker) {
  using Clock = std::chrono::steady_clock;
  bool is_idle = true;  // a worker that never had a job keeps nothing that it could give up
  Clock::time_point last_job;
  while (true) {
    const auto idle_at = when_idle_ && !is_idle ? std::optional(last_job + when_idle_->after) : std::nullopt;
    std::optional<FairQueue::Started> started;
    switch (wait_for_turn(idle_at, started)) {
      case Turn::kEnd:
        return;
      case Turn::kIdle:
        is_idle = true;
        when_idle_->run(worker);
        break;
      case Turn::kJob: {
        const auto begin = Clock::now();
        started->job.run(worker);
        started->job = {};  // frees what the job keeps before its place is free
        last_job = Clock::now();
        is_idle = false;
        const MutexLock lock(mutex_);
        queue_.finish(started->ticket, last_job - begin);
        break;
      }
    }
  }
}

WorkerPool::Turn WorkerPool::wait_for_turn(std::optional<std::chrono::steady_clock::time_point> idle_at,
                                           std::optional<FairQueue::Started>& job) {
  const MutexLock lock(mutex_);
  while (!stopping_ && queue_.waiting() == 0) {
    if (!idle_at) {
      work_or_stop_.wait(mutex_);
    } else if (!work_or_stop_.wait_until(mutex_, *idle_at) && !stopping_ && queue_.waiting() == 0) {
      return Turn::kIdle;
    }
  }
  job = queue_.start_next();
  return job ? Turn::kJob : Turn::kEnd;
}

}  // namespace segserve::server
