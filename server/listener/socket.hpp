// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// A file descriptor that is closed with its object.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Socket() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  int descriptor() const { return descriptor_; }
  /// Leaves the descriptor to the caller, who closes it.
  int release() { return std::exchange(descriptor_, -1); }
  bool is_open() const { return descriptor_ >= 0; }

 private:
  int descriptor_ = -1;
};

/// A socket that listens at the address and does not block. UNAVAILABLE with the reason if that fails.
absl::StatusOr<Socket> listen_at(const ListenAddress& address);

/// Sockets that listen at all addresses of the host, with one port. All addresses of IPv4 stand for all of IPv6, too,
/// where there is IPv6. UNAVAILABLE with the reason if none can be bound.
absl::StatusOr<std::vector<Socket>> listen_at_all(const ListenAddress& address);

/// The other end of a connection, as gRPC names it, but with plain brackets; empty if it has gone already.
std::string peer_name(int connection);

/// The port of a socket that listens, and whether its address is one of IPv6.
int port_of(const Socket& socket);
bool is_ipv6(const Socket& socket);

}  // namespace segserve::server
