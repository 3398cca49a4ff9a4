// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/socket.h>

#include <chrono>
#include <vector>

#include "server/options/listen_address.hpp"

namespace segserve::server {

/// The kinds of things that can be at an address where a server may listen.
enum class Listener {
  kNone,           ///< nobody takes connections
  kSilent,         ///< a connection was made, but nobody says anything on it
  kAnswers,        ///< a server greets the connection, or closes it
  kNoDescriptors,  ///< this process, or the machine, has no file descriptor left for a connection
  kUnknown,        ///< this process can make no connection at present, for another reason
};

/// Finds out who serves at an address. The name of a host is looked up once, at the beginning, because a lookup needs
/// file descriptors, too.
class ListenerProbe {
 public:
  ListenerProbe(const ListenAddress& address, int port);

  /// Connects to the address, or to all that it stands for until one answers, with the greeting of HTTP/2. Waits for
  /// each at most `timeout` to connect, and as long for an answer.
  Listener look(std::chrono::milliseconds timeout) const;

 private:
  struct Target {
    sockaddr_storage address{};
    socklen_t length = 0;
  };

  void add_unix(const std::string& path);
  void add_host(const std::string& host, int port);
  static Listener greet(int connection, const Target& target);
  static Listener look(const Target& target, std::chrono::milliseconds timeout);

  std::vector<Target> targets_;
};

}  // namespace segserve::server
