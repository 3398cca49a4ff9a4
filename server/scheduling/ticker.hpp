// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

/// A thread that calls a function again and again, and waits for `interval` before each call.
class Ticker {
 public:
  /// There are no more calls once `tick` has returned false. It must not throw.
  Ticker(std::chrono::milliseconds interval, std::function<bool()> tick);
  /// Waits for a call that is under way.
  ~Ticker();
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;

 private:
  /// False if the thread shall end.
  bool wait();

  const std::chrono::milliseconds interval_;
  Mutex mutex_;
  CondVar stop_requested_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace segserve::server
