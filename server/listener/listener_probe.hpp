// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "server/options/listen_address.hpp"

namespace segserve::server {

/// What is at an address where a server may listen.
enum class Listener {
  kNone,     ///< nobody takes connections
  kSilent,   ///< a connection was made, but nobody says anything on it
  kAnswers,  ///< a server greets the connection, or closes it
  kUnknown,  ///< this process can make no connection at present, for example because it has too many files open
};

/// Connects to the address, or to all that it stands for until one answers, with the greeting of HTTP/2. Waits for each
/// at most `timeout` to connect, and as long for an answer.
Listener probe_listener(const ListenAddress& address, int port, std::chrono::milliseconds timeout);

}  // namespace segserve::server
