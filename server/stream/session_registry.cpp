// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_registry.hpp"

#include <utility>

#include "absl/status/status.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/scheduling/refusals.hpp"

namespace segserve::server {

SessionRegistry::SessionRegistry(std::chrono::milliseconds tick, std::function<void()> on_tick)
    : on_tick_(std::move(on_tick)), ticker_(tick, [this] {
        this->tick();
        return true;
      }) {}

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

std::size_t SessionRegistry::count() const {
  const MutexLock lock(mutex_);
  return sessions_.size();
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

void SessionRegistry::tick() {
  // Without memory for a tick, the next one does its work.
  const absl::Status ticked = catch_exceptions("look for what takes too long", [this] {
    for (const auto& session : snapshot()) session->on_tick();
    if (on_tick_) on_tick_();
    return absl::OkStatus();
  });
  ticked.IgnoreError();
}

}  // namespace segserve::server
