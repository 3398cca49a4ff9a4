// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The open streams of a server, and the thread that calls StreamSession::on_tick for all of them. Thread-safe.
class SessionRegistry {
 public:
  /// `on_tick` is called at every tick, too, and must not throw.
  explicit SessionRegistry(std::chrono::milliseconds tick, std::function<void()> on_tick = nullptr);
  ~SessionRegistry();
  SessionRegistry(const SessionRegistry&) = delete;
  SessionRegistry& operator=(const SessionRegistry&) = delete;

  void add(const std::shared_ptr<StreamSession>& session);
  void remove(const std::shared_ptr<StreamSession>& session);

  /// Makes all present and later sessions drain.
  void start_draining();
  /// Ends all present sessions with UNAVAILABLE, DRAINING.
  void abort_all();

 private:
  using Sessions = std::set<std::shared_ptr<StreamSession>>;

  void run();
  /// False if the thread shall end.
  bool wait_for_tick();
  /// Sessions are called without the lock: they may end within the call, and are then removed.
  Sessions snapshot() const;

  const std::chrono::milliseconds tick_;
  const std::function<void()> on_tick_;
  mutable Mutex mutex_;
  CondVar stop_requested_;
  Sessions sessions_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace segserve::server
