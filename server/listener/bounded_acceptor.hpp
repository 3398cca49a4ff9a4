// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "server/listener/socket.hpp"

namespace segserve::server {

/// Accepts the connections of a listener and gives them away, but keeps an eye on each: one connection too many ends
/// the oldest one. gRPC 1.51 cannot do that for the ports that it listens on itself. A connection takes two
/// descriptors.
class BoundedAcceptor {
 public:
  static constexpr std::size_t kDescriptorsOfConnection = 2;

  /// Receives a connection, in a thread of the acceptor. It must end the connection by `shutdown`, as gRPC does, and
  /// not by `close` alone, because the acceptor has a descriptor of it, too.
  using Take = std::function<void(Socket)>;

  /// Begins with a socket that listens and does not block. UNAVAILABLE if there are too many open files.
  static absl::StatusOr<std::unique_ptr<BoundedAcceptor>> start(Socket listener, std::size_t most, Take take);

  BoundedAcceptor(const BoundedAcceptor&) = delete;
  BoundedAcceptor& operator=(const BoundedAcceptor&) = delete;
  /// Accepts no more; what was given away goes on.
  ~BoundedAcceptor();

  int port() const { return port_of(listener_); }

 private:
  /// `wake` is an eventfd.
  BoundedAcceptor(Socket listener, Socket wake, std::size_t most, Take take);

  void run();
  /// Waits until there is something to do, and forgets connections that have ended; false if the acceptor shall end.
  bool wait();
  /// False if a connection could not be accepted, for example because there are too many open files.
  bool accept_all();
  void watch(Socket connection);

  const Socket listener_, wake_;
  const std::size_t most_;
  const Take take_;
  bool pauses_ = false;
  std::list<Socket> connections_;  // the oldest first; duplicates of what was given away
  std::vector<pollfd> polled_;
  std::thread thread_;
};

}  // namespace segserve::server
