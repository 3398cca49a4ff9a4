// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <set>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/scheduling/ticker.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The open streams of a server. Calls StreamSession::on_tick for all of them on a thread of its own. Thread-safe.
class SessionRegistry {
 public:
  /// `on_tick` is called at every tick, after the sessions. If it throws, the next tick does its work.
  explicit SessionRegistry(std::chrono::milliseconds tick, std::function<void()> on_tick = nullptr);

  void add(const std::shared_ptr<StreamSession>& session);
  void remove(const std::shared_ptr<StreamSession>& session);

  /// Streams that are open.
  std::size_t count() const;

  /// Makes all present and later sessions drain.
  void start_draining();
  /// Ends all present sessions with UNAVAILABLE, DRAINING.
  void abort_all();

 private:
  using Sessions = std::set<std::shared_ptr<StreamSession>>;

  void tick();
  /// Sessions are called without the lock: they may end within the call, and are then removed.
  Sessions snapshot() const;

  const std::function<void()> on_tick_;
  mutable Mutex mutex_;
  Sessions sessions_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  Ticker ticker_;  // is destroyed first
};

}  // namespace segserve::server
