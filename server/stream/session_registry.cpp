// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_registry.hpp"

#include <utility>

#include "absl/status/status.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/scheduling/refusals.hpp"

namespace segserve::server {

SessionRegistry::SessionRegistry(std::chrono::milliseconds tick, std::function<void()> on_tick)
    : tick_(tick), on_tick_(std::move(on_tick)), thread_([this] { run(); }) {}

SessionRegistry::~SessionRegistry() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    stop_requested_.notify_all();
  }
  thread_.join();
}

void SessionRegistry::add(const std::shared_ptr<StreamSession>& session) {
  bool draining = false;
  {
    const MutexLock lock(mutex_);
    sessions_.insert(session);
    draining = draining_;
  }
  if (draining) session->start_draining();
}

void SessionRegistry::remove(const std::shared_ptr<StreamSession>& session) {
  const MutexLock lock(mutex_);
  sessions_.erase(session);
}

void SessionRegistry::start_draining() {
  {
    const MutexLock lock(mutex_);
    draining_ = true;
  }
  for (const auto& session : snapshot()) session->start_draining();
}

void SessionRegistry::abort_all() {
  for (const auto& session : snapshot()) session->on_cancel(draining());
}

SessionRegistry::Sessions SessionRegistry::snapshot() const {
  const MutexLock lock(mutex_);
  return sessions_;
}

void SessionRegistry::run() {
  while (wait_for_tick()) {
    // Without memory for a tick, the next one does its work.
    const absl::Status ticked = catch_exceptions([this] {
      for (const auto& session : snapshot()) session->on_tick();
      if (on_tick_) on_tick_();
      return absl::OkStatus();
    });
    ticked.IgnoreError();
  }
}

bool SessionRegistry::wait_for_tick() {
  const auto next_tick = std::chrono::steady_clock::now() + tick_;
  const MutexLock lock(mutex_);
  while (!stopping_ && stop_requested_.wait_until(mutex_, next_tick)) {
  }
  return !stopping_;
}

}  // namespace segserve::server
