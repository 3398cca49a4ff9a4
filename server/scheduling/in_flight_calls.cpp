// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/in_flight_calls.hpp"

namespace segserve::server {

bool InFlightCalls::admit() {
  const MutexLock lock(mutex_);
  if (!closed_) ++count_;
  return !closed_;
}

void InFlightCalls::release() {
  const MutexLock lock(mutex_);
  // Signals with the lock held, because the waiting thread may destroy this object as soon as it sees 0.
  if (--count_ == 0) none_left_.notify_all();
}

void InFlightCalls::close() {
  const MutexLock lock(mutex_);
  closed_ = true;
}

void InFlightCalls::wait_until_none() {
  const MutexLock lock(mutex_);
  while (count_ > 0) none_left_.wait(mutex_);
}

bool InFlightCalls::wait_until_none_or(std::chrono::steady_clock::time_point deadline) {
  const MutexLock lock(mutex_);
  while (count_ > 0 && none_left_.wait_until(mutex_, deadline)) {
  }
  return count_ == 0;
}

std::size_t InFlightCalls::count() const {
  const MutexLock lock(mutex_);
  return count_;
}

bool InFlightCalls::is_closed() const {
  const MutexLock lock(mutex_);
  return closed_;
}

}  // namespace segserve::server
