// SPDX-License-Identifier: Apache-2.0
#include "server/listener/listener_probe.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace segserve::server {
namespace {

// RFC 9113, section 3.4: the preface of a client, and its empty SETTINGS frame.
constexpr std::string_view kGreeting("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);

struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

std::vector<SocketAddress> unix_address(const std::string& path) {
  SocketAddress found;
  auto& address = reinterpret_cast<sockaddr_un&>(found.storage);
  if (path.size() >= sizeof(address.sun_path)) return {};
  address.sun_family = AF_UNIX;
  std::ranges::copy(path, address.sun_path);
  found.length = sizeof(address);
  return {found};
}

/// All addresses to which a server may have bound. A server that binds the wildcard of IPv6 serves IPv4, too.
std::vector<SocketAddress> addresses_of(const ListenAddress& address, int port) {
  if (address.is_unix) return unix_address(address.host);
  std::vector<std::string> hosts{address.host};
  if (address.host == "0.0.0.0" || address.host == "::") hosts = {"127.0.0.1", "::1"};
  std::vector<SocketAddress> found;
  for (const std::string& host : hosts) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_NUMERICSERV;
    addrinfo* list = nullptr;
    if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list) != 0) continue;
    for (const addrinfo* each = list; each != nullptr; each = each->ai_next) {
      SocketAddress& added = found.emplace_back();
      std::memcpy(&added.storage, each->ai_addr, each->ai_addrlen);
      added.length = each->ai_addrlen;
    }
    freeaddrinfo(list);
  }
  return found;
}

Listener greet(int connection, const SocketAddress& address) {
  if (connect(connection, reinterpret_cast<const sockaddr*>(&address.storage), address.length) != 0) {
    // A full queue of connections that nobody accepts shows as a timeout, and at a unix socket as EAGAIN.
    if (errno == EINPROGRESS || errno == EAGAIN || errno == ETIMEDOUT) return Listener::kSilent;
    return errno == ECONNREFUSED || errno == ENOENT ? Listener::kNone : Listener::kUnknown;
  }
  if (send(connection, kGreeting.data(), kGreeting.size(), MSG_NOSIGNAL) < 0) return Listener::kAnswers;
  char byte = 0;
  const ssize_t received = recv(connection, &byte, 1, 0);
  return received < 0 && (errno == EAGAIN || errno == EWOULDBLOCK) ? Listener::kSilent : Listener::kAnswers;
}

Listener probe(const SocketAddress& target, std::chrono::milliseconds timeout) {
  const int connection = socket(target.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connection < 0) return Listener::kUnknown;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  const auto rest = std::chrono::duration_cast<std::chrono::microseconds>(timeout - seconds);
  const timeval limit{.tv_sec = seconds.count(), .tv_usec = rest.count()};
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  // The limit of sending is also that of connecting.
  setsockopt(connection, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));
  const Listener found = greet(connection, target);
  close(connection);
  return found;
}

}  // namespace

Listener probe_listener(const ListenAddress& address, int port, std::chrono::milliseconds timeout) {
  Listener best = Listener::kUnknown;
  for (const SocketAddress& target : addresses_of(address, port)) {
    const Listener found = probe(target, timeout);
    if (found == Listener::kAnswers) return found;
    if (best == Listener::kUnknown || found == Listener::kSilent) best = found;
  }
  return best;
}

}  // namespace segserve::server
