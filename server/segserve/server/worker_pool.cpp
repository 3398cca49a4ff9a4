#include "segserve/server/worker_pool.hpp"

#include <algorithm>
#include <utility>

namespace segserve::server {

WorkerPool::WorkerPool(std::size_t workers, std::size_t max_queue) : capacity_(workers + max_queue) {
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

std::optional<WorkerPool::Ticket> WorkerPool::submit(Job job) {
  Ticket ticket = 0;
  {
    const std::lock_guard lock(mutex_);
    if (running_ + queue_.size() >= capacity_) return std::nullopt;
    ticket = next_ticket_++;
    queue_.push_back({ticket, std::move(job)});
  }
  work_or_stop_.notify_one();
  return ticket;
}

bool WorkerPool::withdraw(Ticket ticket) {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(queue_, ticket, &Entry::ticket);
  if (found == queue_.end()) return false;
  queue_.erase(found);
  return true;
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

void WorkerPool::run(std::size_t worker) {
  std::unique_lock lock(mutex_);
  while (true) {
    work_or_stop_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const Job job = std::move(queue_.front().job);
    queue_.pop_front();
    ++running_;
    lock.unlock();
    job(worker);
    lock.lock();
    --running_;
  }
}

}  // namespace segserve::server
