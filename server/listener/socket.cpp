// SPDX-License-Identifier: Apache-2.0
#include "server/listener/socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace segserve::server {
namespace {

absl::Status failure(const char* text) { return absl::UnavailableError(text); }

absl::StatusOr<Socket> listen_at(const addrinfo& address) {
  Socket socket(::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.is_open()) return failure(std::strerror(errno));
  const int yes = 1;  // a server that starts again need not wait until the last connections are forgotten
  setsockopt(socket.descriptor(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const int no = 0;  // the address for all of IPv6 is one for all of IPv4, too
  if (address.ai_family == AF_INET6) setsockopt(socket.descriptor(), IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
  if (bind(socket.descriptor(), address.ai_addr, address.ai_addrlen) != 0 ||
      listen(socket.descriptor(), SOMAXCONN) != 0) {
    return failure(std::strerror(errno));
  }
  return socket;
}

}  // namespace

absl::StatusOr<Socket> listen_at(const ListenAddress& address) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0) {
    return failure(gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  absl::StatusOr<Socket> socket = failure("the host has no address");
  for (const addrinfo* each = found; each != nullptr && !socket.ok(); each = each->ai_next) socket = listen_at(*each);
  return socket;
}

bool is_ipv6(const Socket& socket) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  return getsockname(socket.descriptor(), reinterpret_cast<sockaddr*>(&address), &length) == 0 &&
         address.ss_family == AF_INET6;
}

int port_of(const Socket& socket) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  if (getsockname(socket.descriptor(), reinterpret_cast<sockaddr*>(&address), &length) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

}  // namespace segserve::server
