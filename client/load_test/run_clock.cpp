// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/run_clock.hpp"

#include <algorithm>

namespace segserve::bench {
namespace {

// A thread that wakes up a little after the end may send what was due before.
constexpr std::chrono::milliseconds kGrace{250};

}  // namespace

RunClock::RunClock(Time begin, Duration warm_up, Duration window, Duration drain)
    : begin_(begin), measured_from_(begin + warm_up), end_(measured_from_ + window), drain_end_(end_ + drain) {}

RunClock::Time RunClock::end() const {
  const MutexLock lock(mutex_);
  return end_;
}

RunClock::Time RunClock::drain_end() const {
  const MutexLock lock(mutex_);
  return drain_end_;
}

void RunClock::stop(Time now, Duration drain) {
  const MutexLock lock(mutex_);
  end_ = std::min(end_, now);
  drain_end_ = std::min(drain_end_, std::max(end_, now) + drain);
  stopped_.notify_all();
}

void RunClock::interrupt(Time now, Duration drain) {
  stop(now, drain);
  const MutexLock lock(mutex_);
  interrupted_ = true;
}

bool RunClock::interrupted() const {
  const MutexLock lock(mutex_);
  return interrupted_;
}

bool RunClock::sleep_until(Time until) {
  const MutexLock lock(mutex_);
  while (until < end_) {
    const Time now = client::Clock::now();
    if (now >= end_ + kGrace) return false;
    if (now >= until) return true;
    stopped_.wait_until(mutex_, until);
  }
  return false;
}

}  // namespace segserve::bench
