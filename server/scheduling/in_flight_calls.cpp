#include "server/scheduling/in_flight_calls.hpp"

namespace segserve::server {

bool InFlightCalls::enter() {
  const std::lock_guard lock(mutex_);
  if (!closed_) ++inside_;
  return !closed_;
}

void InFlightCalls::leave() {
  const std::lock_guard lock(mutex_);
  // Under the lock: the waiter may destroy the gate as soon as it sees it empty.
  if (--inside_ == 0) empty_.notify_all();
}

void InFlightCalls::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

void InFlightCalls::wait_until_empty() {
  std::unique_lock lock(mutex_);
  empty_.wait(lock, [this] { return inside_ == 0; });
}

bool InFlightCalls::wait_until_empty_or(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  return empty_.wait_until(lock, deadline, [this] { return inside_ == 0; });
}

std::size_t InFlightCalls::inside() const {
  const std::lock_guard lock(mutex_);
  return inside_;
}

}  // namespace segserve::server
