#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include "server/stream/stream_session.hpp"

namespace segserve::server {

/// The open streams of a server, and the thread that looks after the time of their frames. Thread-safe.
class SessionRegistry {
 public:
  explicit SessionRegistry(std::chrono::milliseconds tick);
  ~SessionRegistry();
  SessionRegistry(const SessionRegistry&) = delete;
  SessionRegistry& operator=(const SessionRegistry&) = delete;

  void add(const std::shared_ptr<StreamSession>& session);
  void remove(const std::shared_ptr<StreamSession>& session);

  /// All sessions of now and later drain.
  void start_draining();

 private:
  using Sessions = std::set<std::shared_ptr<StreamSession>>;

  void run();
  Sessions snapshot() const;

  const std::chrono::milliseconds tick_;
  mutable std::mutex mutex_;
  std::condition_variable stop_or_tick_;
  Sessions sessions_;
  bool draining_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace segserve::server
