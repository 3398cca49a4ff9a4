// SPDX-License-Identifier: Apache-2.0
#include "server/listener/listener_probe.hpp"

#include <netdb.h>
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

}  // namespace

ListenerProbe::ListenerProbe(const ListenAddress& address, int port) {
  if (address.is_unix) {
    add_unix(address.host);
    return;
  }
  // A server that binds the wildcard of IPv6 serves IPv4, too.
  std::vector<std::string> hosts{address.host};
  if (address.host == "0.0.0.0" || address.host == "::") hosts = {"127.0.0.1", "::1"};
  for (const std::string& host : hosts) add_host(host, port);
}

void ListenerProbe::add_unix(const std::string& path) {
  Target target;
  auto& name = reinterpret_cast<sockaddr_un&>(target.address);
  if (path.size() >= sizeof(name.sun_path)) return;
  name.sun_family = AF_UNIX;
  std::ranges::copy(path, name.sun_path);
  target.length = sizeof(name);
  targets_.push_back(target);
}

void ListenerProbe::add_host(const std::string& host, int port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* list = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list) != 0) return;
  for (const addrinfo* each = list; each != nullptr; each = each->ai_next) {
    Target& target = targets_.emplace_back();
    std::memcpy(&target.address, each->ai_addr, each->ai_addrlen);
    target.length = each->ai_addrlen;
  }
  freeaddrinfo(list);
}

Listener ListenerProbe::greet(int connection, const Target& target) {
  if (connect(connection, reinterpret_cast<const sockaddr*>(&target.address), target.length) != 0) {
    // A full queue of connections that nobody accepts shows as a timeout, and at a unix socket as EAGAIN.
    if (errno == EINPROGRESS || errno == EAGAIN || errno == ETIMEDOUT) return Listener::kSilent;
    return errno == ECONNREFUSED || errno == ENOENT ? Listener::kNone : Listener::kUnknown;
  }
  if (send(connection, kGreeting.data(), kGreeting.size(), MSG_NOSIGNAL) < 0) return Listener::kAnswers;
  char byte = 0;
  const ssize_t received = recv(connection, &byte, 1, 0);
  return received < 0 && (errno == EAGAIN || errno == EWOULDBLOCK) ? Listener::kSilent : Listener::kAnswers;
}

Listener ListenerProbe::look(const Target& target, std::chrono::milliseconds timeout) {
  const int connection = socket(target.address.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connection < 0) return errno == EMFILE || errno == ENFILE ? Listener::kNoDescriptors : Listener::kUnknown;
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

Listener ListenerProbe::look(std::chrono::milliseconds timeout) const {
  Listener best = Listener::kUnknown;
  for (const Target& target : targets_) {
    const Listener found = look(target, timeout);
    if (found == Listener::kAnswers || found == Listener::kNoDescriptors) return found;
    if (best == Listener::kUnknown || found == Listener::kSilent) best = found;
  }
  return best;
}

}  // namespace segserve::server
