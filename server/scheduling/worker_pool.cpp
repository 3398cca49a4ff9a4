// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/worker_pool.hpp"

#include <algorithm>
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
    const MutexLock lock(mutex_);
    stopping_ = true;
    work_or_stop_.notify_all();
  }
  for (std::thread& thread : threads_) thread.join();
}

std::variant<WorkerPool::Ticket, Refusal> WorkerPool::submit(JobInfo info, Job job) {
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

std::size_t WorkerPool::queued() const {
  const MutexLock lock(mutex_);
  return queue_.waiting();
}

QueueBounds WorkerPool::held() const {
  const MutexLock lock(mutex_);
  return queue_.held();
}

std::chrono::milliseconds WorkerPool::retry_delay() const {
  using std::chrono::milliseconds;
  const MutexLock lock(mutex_);
  const auto delay = std::chrono::duration_cast<milliseconds>(queue_.backlog()) / threads_.size();
  return std::clamp<milliseconds>(delay, milliseconds(20), milliseconds(10'000));
}

void WorkerPool::run(std::size_t worker) {
  while (std::optional<FairQueue::Started> started = wait_for_job()) {
    const auto begin = std::chrono::steady_clock::now();
    started->job.run(worker);
    started->job = {};  // frees what the job keeps before its place is free
    const auto took = std::chrono::steady_clock::now() - begin;
    const MutexLock lock(mutex_);
    queue_.finish(started->ticket, took);
  }
}

std::optional<FairQueue::Started> WorkerPool::wait_for_job() {
  const MutexLock lock(mutex_);
  while (!stopping_ && queue_.waiting() == 0) work_or_stop_.wait(mutex_);
  return queue_.start_next();
}

}  // namespace segserve::server
