// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

/// Counts the calls in flight and admits no new one once it is closed, so that a server can drain. Thread-safe.
class InFlightCalls {
 public:
  /// False once closed. Every call that was admitted is released exactly once.
  bool admit();
  void release();

  void close();
  /// Waits until no call is in flight.
  void wait_until_none();
  /// Does the same, but returns false if that takes longer than the deadline.
  bool wait_until_none_or(std::chrono::steady_clock::time_point deadline);
  std::size_t count() const;
  bool is_closed() const;

 private:
  mutable Mutex mutex_;
  CondVar none_left_;
  std::size_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::server
