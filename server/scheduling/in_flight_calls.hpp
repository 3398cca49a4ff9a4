#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>

namespace segserve::server {

/// Counts the calls in flight, and lets no new one in once it is closed: how a server drains.
class InFlightCalls {
 public:
  /// False if the gate is closed. Whoever was let in calls `leave` exactly once.
  bool enter();
  void leave();

  void close();
  /// Waits until nobody is in.
  void wait_until_empty();
  /// The same, but false if that takes longer than the deadline.
  bool wait_until_empty_or(std::chrono::steady_clock::time_point deadline);
  std::size_t inside() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable empty_;
  std::size_t inside_ = 0;
  bool closed_ = false;
};

}  // namespace segserve::server
