#include "server/call_gate.hpp"

namespace segserve::server {

bool CallGate::enter() {
  const std::lock_guard lock(mutex_);
  if (!closed_) ++inside_;
  return !closed_;
}

void CallGate::leave() {
  const std::lock_guard lock(mutex_);
  // Under the lock: the waiter may destroy the gate as soon as it sees it empty.
  if (--inside_ == 0) empty_.notify_all();
}

void CallGate::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

void CallGate::wait_until_empty() {
  std::unique_lock lock(mutex_);
  empty_.wait(lock, [this] { return inside_ == 0; });
}

bool CallGate::wait_until_empty_or(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  return empty_.wait_until(lock, deadline, [this] { return inside_ == 0; });
}

std::size_t CallGate::inside() const {
  const std::lock_guard lock(mutex_);
  return inside_;
}

}  // namespace segserve::server
