// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/asio/any_io_executor.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"

namespace segserve::server {

/// A connection as others see it than its own steps.
class HttpConnection {
 public:
  using Time = std::chrono::steady_clock::time_point;
  enum class Phase : std::uint8_t { kIdle, kBusy };

  HttpConnection(boost::asio::any_io_executor executor, std::string peer);

  /// The other end, as gRPC names it.
  const std::string& peer() const { return peer_; }
  /// The address of the peer; see client_address.
  const std::string& address() const { return address_; }

  /// Cuts the connection soon. From any thread.
  static void cut(const std::shared_ptr<HttpConnection>& connection);

  /// Begins a phase, and notes the time.
  void enter(Phase phase);
  Phase phase() const { return phase_; }
  Time since() const { return since_; }

  /// The stream that `cut` closes; null when there is none any more. To be called in the order of the connection's
  /// steps only.
  void attach(boost::beast::tcp_stream* stream);

 private:
  const boost::asio::any_io_executor executor_;
  const std::string peer_, address_;
  std::atomic<Phase> phase_{Phase::kIdle};
  std::atomic<Time> since_;
  // Used in the order of the connection's steps only.
  boost::beast::tcp_stream* stream_ = nullptr;
  bool is_cut_ = false;
};

/// The connections of a server. Thread-safe.
class HttpConnections {
 public:
  /// Adds a connection. If there are `most` already, one makes way for it: the one that has been idle for longest, or
  /// else, of the address that has most connections, the one that has been busy for longest with the same step. False
  /// if they are closed.
  bool add(const std::shared_ptr<HttpConnection>& connection, std::size_t most);
  void remove(const HttpConnection& connection);
  /// Cuts all connections, and takes no more.
  void close();

 private:
  using List = std::list<std::shared_ptr<HttpConnection>>;

  List::iterator least_needed() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Mutex mutex_;
  List connections_ ABSL_GUARDED_BY(mutex_);  // the oldest first
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace segserve::server
