#include "server/stream/session_registry.hpp"

namespace segserve::server {

SessionRegistry::SessionRegistry(std::chrono::milliseconds tick) : tick_(tick), thread_([this] { run(); }) {}

SessionRegistry::~SessionRegistry() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stop_or_tick_.notify_all();
  thread_.join();
}

void SessionRegistry::add(const std::shared_ptr<StreamSession>& session) {
  bool draining = false;
  {
    const std::lock_guard lock(mutex_);
    sessions_.insert(session);
    draining = draining_;
  }
  if (draining) session->start_draining();
}

void SessionRegistry::remove(const std::shared_ptr<StreamSession>& session) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(session);
}

void SessionRegistry::start_draining() {
  {
    const std::lock_guard lock(mutex_);
    draining_ = true;
  }
  for (const auto& session : snapshot()) session->start_draining();
}

// Sessions are called without the lock: they may end within, and are removed then.
SessionRegistry::Sessions SessionRegistry::snapshot() const {
  const std::lock_guard lock(mutex_);
  return sessions_;
}

void SessionRegistry::run() {
  std::unique_lock lock(mutex_);
  while (!stop_or_tick_.wait_for(lock, tick_, [this] { return stopping_; })) {
    lock.unlock();
    for (const auto& session : snapshot()) session->on_tick();
    lock.lock();
  }
}

}  // namespace segserve::server
