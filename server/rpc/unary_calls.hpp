// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <set>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

class SegmentCall;

/// The unary calls of a server, from their arrival until gRPC is done with them. Thread-safe.
class UnaryCalls {
 public:
  void add(std::shared_ptr<SegmentCall> call);
  void remove(const std::shared_ptr<SegmentCall>& call);

  std::size_t count() const;

  /// Ends the calls whose answers clients do not read. To be called now and then.
  void on_tick(std::chrono::steady_clock::time_point now);
  /// The server closes: see SegmentCall::abort.
  void abort_all();

 private:
  /// Calls are called without the lock, because they may end within the call, and are then removed.
  std::vector<std::shared_ptr<SegmentCall>> snapshot() const;

  mutable Mutex mutex_;
  std::set<std::shared_ptr<SegmentCall>> calls_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace segserve::server
