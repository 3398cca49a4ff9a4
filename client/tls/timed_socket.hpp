// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace segserve::client {

/// A TCP connection of which each step ends at the same deadline.
class TimedSocket {
 public:
  explicit TimedSocket(std::chrono::milliseconds timeout) : deadline_(std::chrono::steady_clock::now() + timeout) {}
  ~TimedSocket();
  TimedSocket(const TimedSocket&) = delete;
  TimedSocket& operator=(const TimedSocket&) = delete;

  /// Tries all addresses of the host. False if none took the connection.
  bool connect(const std::string& host, const std::string& port);
  bool send(std::string_view bytes);
  /// The number of bytes received, 0 if the other end has closed the connection. Nothing if the time is over.
  std::optional<std::size_t> receive(std::span<char> buffer);

 private:
  /// Waits until the socket is ready for `events` of poll. False if the time is over.
  bool wait(short events) const;

  const std::chrono::steady_clock::time_point deadline_;
  int socket_ = -1;
};

}  // namespace segserve::client
