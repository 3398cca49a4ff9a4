// SPDX-License-Identifier: Apache-2.0
#include "server/scheduling/ticker.hpp"

#include <utility>

namespace segserve::server {

Ticker::Ticker(std::chrono::milliseconds interval, std::function<bool()> tick)
    : interval_(interval), thread_([this, tick = std::move(tick)] {
        while (wait() && tick()) {
        }
      }) {}

Ticker::~Ticker() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    stop_requested_.notify_all();
  }
  thread_.join();
}

bool Ticker::wait() {
  const auto next = std::chrono::steady_clock::now() + interval_;
  const MutexLock lock(mutex_);
  while (!stopping_ && stop_requested_.wait_until(mutex_, next)) {
  }
  return !stopping_;
}

}  // namespace segserve::server
