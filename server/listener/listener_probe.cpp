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

namespace segserve::server {
namespace {

// RFC 9113, section 3.4: the preface of a client, and its empty SETTINGS frame.
constexpr std::string_view kGreeting("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);

struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

bool find_unix_address(const std::string& path, SocketAddress& found) {
  auto& address = reinterpret_cast<sockaddr_un&>(found.storage);
  if (path.size() >= sizeof(address.sun_path)) return false;
  address.sun_family = AF_UNIX;
  std::ranges::copy(path, address.sun_path);
  found.length = sizeof(address);
  return true;
}

bool find_address(const ListenAddress& address, int port, SocketAddress& found) {
  if (address.is_unix) return find_unix_address(address.host, found);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* list = nullptr;
  if (getaddrinfo(address.host.c_str(), std::to_string(port).c_str(), &hints, &list) != 0) return false;
  std::memcpy(&found.storage, list->ai_addr, list->ai_addrlen);
  found.length = list->ai_addrlen;
  freeaddrinfo(list);
  return true;
}

Listener greet(int connection, const SocketAddress& address) {
  if (connect(connection, reinterpret_cast<const sockaddr*>(&address.storage), address.length) != 0) {
    // A full queue of connections that nobody accepts shows as a timeout, and at a unix socket as EAGAIN.
    const bool is_full = errno == EINPROGRESS || errno == EAGAIN || errno == ETIMEDOUT;
    return is_full ? Listener::kSilent : Listener::kNone;
  }
  if (send(connection, kGreeting.data(), kGreeting.size(), MSG_NOSIGNAL) < 0) return Listener::kAnswers;
  char byte = 0;
  const ssize_t received = recv(connection, &byte, 1, 0);
  return received < 0 && (errno == EAGAIN || errno == EWOULDBLOCK) ? Listener::kSilent : Listener::kAnswers;
}

}  // namespace

Listener probe_listener(const ListenAddress& address, int port, std::chrono::milliseconds timeout) {
  SocketAddress target;
  if (!find_address(address, port, target)) return Listener::kUnknown;
  const int connection = socket(target.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connection < 0) return Listener::kUnknown;
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  const auto rest = std::chrono::duration_cast<std::chrono::microseconds>(timeout - seconds);
  const timeval limit{.tv_sec = seconds.count(), .tv_usec = rest.count()};
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  setsockopt(connection, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof(limit));  // also of connecting
  const Listener found = greet(connection, target);
  close(connection);
  return found;
}

}  // namespace segserve::server
