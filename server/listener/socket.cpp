// SPDX-License-Identifier: Apache-2.0
#include "server/listener/socket.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

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

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

absl::StatusOr<Addresses> find_addresses(const ListenAddress& address) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0) {
    return failure(gai_strerror(error));
  }
  return Addresses(found, freeaddrinfo);
}

void set_port(sockaddr& address, int port) {
  const in_port_t bytes = htons(static_cast<std::uint16_t>(port));
  if (address.sa_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6&>(address).sin6_port = bytes;
  } else {
    reinterpret_cast<sockaddr_in&>(address).sin_port = bytes;
  }
}

}  // namespace

absl::StatusOr<Socket> listen_at(const ListenAddress& address) {
  ASSIGN_OR_RETURN(const Addresses addresses, find_addresses(address));
  absl::StatusOr<Socket> socket = failure("the host has no address");
  for (const addrinfo* each = addresses.get(); each != nullptr && !socket.ok(); each = each->ai_next)
    socket = listen_at(*each);
  return socket;
}

absl::StatusOr<std::vector<Socket>> listen_at_all(const ListenAddress& address) {
  std::vector<Socket> sockets;
  if (address.host == "0.0.0.0" || address.host == "::") {
    ListenAddress all = address;
    all.host = "::";
    absl::StatusOr<Socket> socket = listen_at(all);
    all.host = "0.0.0.0";
    if (!socket.ok()) socket = listen_at(all);
    if (!socket.ok()) return socket.status();
    sockets.push_back(*std::move(socket));
    return sockets;
  }
  ASSIGN_OR_RETURN(const Addresses addresses, find_addresses(address));
  absl::Status failed = failure("the host has no address");
  for (const addrinfo* each = addresses.get(); each != nullptr; each = each->ai_next) {
    if (!sockets.empty()) set_port(*each->ai_addr, port_of(sockets.front()));
    absl::StatusOr<Socket> socket = listen_at(*each);
    if (socket.ok()) {
      sockets.push_back(*std::move(socket));
    } else {
      failed = socket.status();
    }
  }
  if (sockets.empty()) return failed;
  return sockets;
}

std::string peer_name(int connection) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  std::array<char, INET6_ADDRSTRLEN> host{};
  std::array<char, sizeof "65535"> port{};
  auto& peer = reinterpret_cast<sockaddr&>(address);
  if (getpeername(connection, &peer, &length) != 0 || getnameinfo(&peer, length, host.data(), host.size(), port.data(),
                                                                  port.size(), NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return "";
  }
  const char* const form = address.ss_family == AF_INET6 ? "ipv6:[{}]:{}" : "ipv4:{}:{}";
  return fmt::format(fmt::runtime(form), host.data(), port.data());
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
