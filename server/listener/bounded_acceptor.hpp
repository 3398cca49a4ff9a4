// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.hpp"
#include "server/listener/socket.hpp"

namespace segserve::server {

/// Accepts the connections of listeners and gives them away, but keeps an eye on each: one connection too many ends
/// the oldest one of the address that has most. gRPC 1.51 cannot do that for the ports that it listens on itself. A
/// connection takes two descriptors.
class BoundedAcceptor {
 public:
  static constexpr std::size_t kDescriptorsOfConnection = 2;

  /// Receives a connection, in a thread of the acceptor. It must end the connection by `shutdown`, as gRPC does, and
  /// not by `close` alone, because the acceptor has a descriptor of it, too.
  using Take = std::function<void(Socket)>;

  /// Whether new connections of an address, as client_address names it, shall wait a while. Is asked in a thread of
  /// the acceptor.
  using Holds = std::function<bool(const std::string& address)>;

  /// Begins with sockets that listen and do not block. UNAVAILABLE if there are too many open files.
  static absl::StatusOr<std::unique_ptr<BoundedAcceptor>> start(std::vector<Socket> listeners, std::size_t most,
                                                                Take take, Holds holds);

  BoundedAcceptor(const BoundedAcceptor&) = delete;
  BoundedAcceptor& operator=(const BoundedAcceptor&) = delete;
  ~BoundedAcceptor() { close(); }

  /// Accepts no more; what was given away goes on.
  void close();
  /// Ends a connection that was given away, and drops what has come by it. Its name is that of connection_name.
  void end(const std::string& name) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The number of connections that were accepted so far.
  std::uint64_t accepted() const { return accepted_; }

 private:
  /// `wake` is an eventfd.
  BoundedAcceptor(std::vector<Socket> listeners, Socket wake, std::size_t most, Take take, Holds holds);

  struct Connection {
    Socket duplicate;  // of what was given away
    std::string address, name;
  };

  void run();
  /// Waits until there is something to do, and forgets connections that have ended; false if the acceptor shall end.
  bool wait();
  /// False if a connection could not be accepted, for example because there are too many open files.
  bool accept_all();
  bool accept_all(const Socket& listener);
  /// Gives away what needs not wait any more.
  void release_held();
  void take(Socket connection);
  void watch(Socket connection, std::string address, std::string name);
  void end_one();
  /// Forgets a connection; returns the next one.
  std::list<Connection>::iterator forget(std::list<Connection>::iterator connection);

  std::vector<Socket> listeners_;
  const Socket wake_;
  const std::size_t most_;
  const Take take_;
  const Holds holds_;
  bool pauses_ = false;
  std::atomic<std::uint64_t> accepted_{0};
  std::list<Connection> connections_;          // the oldest first
  std::map<std::string, std::size_t> counts_;  // of the connections of each address
  std::list<Socket> held_;                     // the oldest first
  Mutex mutex_;
  std::map<std::string, int> descriptors_ ABSL_GUARDED_BY(mutex_);  // of the duplicates, by name
  std::vector<pollfd> polled_;
  std::thread thread_;
};

}  // namespace segserve::server
