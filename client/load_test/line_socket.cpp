// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/line_socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace segserve::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kSendTime{10};

absl::Status unavailable(const char* why) { return absl::UnavailableError(why); }

/// Waits for `events` of poll; false if the time is over.
bool wait(int descriptor, short events, Clock::time_point until) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd waiting{.fd = descriptor, .events = events, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::clamp<long>(left, 0, 3'600'000)));
    if (ready > 0) return true;
    if (ready == 0 && left <= 0) return false;
    if (ready < 0 && errno != EINTR) return false;
  }
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

absl::StatusOr<Addresses> look_up(const std::string& host, const std::string& port, int flags) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); error != 0) {
    return unavailable(gai_strerror(error));
  }
  return Addresses(found, freeaddrinfo);
}

int open_socket(const addrinfo& address) {
  return socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

/// 0, or the errno of the attempt.
int try_connect(int descriptor, const addrinfo& address, Clock::time_point until) {
  if (connect(descriptor, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!wait(descriptor, POLLOUT, until)) return ETIMEDOUT;
  int error = 0;
  socklen_t length = sizeof error;
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &length);
  return error;
}

}  // namespace

LineSocket::LineSocket(LineSocket&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), received_(std::move(other.received_)) {}

LineSocket& LineSocket::operator=(LineSocket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(received_, other.received_);
  return *this;
}

LineSocket::~LineSocket() {
  if (descriptor_ >= 0) close(descriptor_);
}

absl::StatusOr<LineSocket> LineSocket::connect(const std::string& host, const std::string& port,
                                               std::chrono::milliseconds timeout) {
  const auto until = Clock::now() + timeout;
  auto addresses = look_up(host, port, 0);
  if (!addresses.ok()) return addresses.status();
  int error = EADDRNOTAVAIL;
  for (const addrinfo* each = addresses->get(); each != nullptr; each = each->ai_next) {
    const int descriptor = open_socket(*each);
    if (descriptor < 0) return unavailable(std::strerror(errno));
    error = try_connect(descriptor, *each, until);
    if (error == 0) return LineSocket(descriptor);
    close(descriptor);
  }
  return unavailable(std::strerror(error));
}

absl::Status LineSocket::send(std::string_view line) { return send_text(std::string(line) + "\n"); }

absl::Status LineSocket::send_text(std::string_view rest) {
  const auto until = Clock::now() + kSendTime;
  while (!rest.empty()) {
    const ssize_t sent = ::send(descriptor_, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      rest.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno != EAGAIN && errno != EINTR) {
      return unavailable(std::strerror(errno));
    } else if (!wait(descriptor_, POLLOUT, until)) {
      return unavailable("the other end takes nothing");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<std::string>> LineSocket::receive(std::chrono::milliseconds time, std::size_t most_bytes) {
  const auto until = Clock::now() + time;
  std::size_t looked_at = 0;
  while (true) {
    const std::size_t end = received_.find('\n', looked_at);
    if (end != std::string::npos) {
      std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      return line;
    }
    looked_at = received_.size();
    if (looked_at > most_bytes) return unavailable("the other end sends a line without an end");
    if (!wait(descriptor_, POLLIN, until)) return std::nullopt;
    std::array<char, 65536> bytes;
    const ssize_t count = recv(descriptor_, bytes.data(), bytes.size(), 0);
    if (count > 0) {
      received_.append(bytes.data(), static_cast<std::size_t>(count));
    } else if (count == 0) {
      return unavailable("the other end has closed the connection");
    } else if (errno != EAGAIN && errno != EINTR) {
      return unavailable(std::strerror(errno));
    }
  }
}

absl::StatusOr<LineListener> LineListener::listen(const std::string& host, const std::string& port) {
  auto addresses = look_up(host, port, AI_PASSIVE | AI_NUMERICSERV);
  if (!addresses.ok()) return addresses.status();
  int error = EADDRNOTAVAIL;
  for (const addrinfo* each = addresses->get(); each != nullptr; each = each->ai_next) {
    LineListener listener(open_socket(*each));
    const int yes = 1;
    if (listener.descriptor_ < 0) return unavailable(std::strerror(errno));
    setsockopt(listener.descriptor_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (bind(listener.descriptor_, each->ai_addr, each->ai_addrlen) == 0 && ::listen(listener.descriptor_, 8) == 0) {
      return listener;
    }
    error = errno;
  }
  return unavailable(std::strerror(error));
}

LineListener::LineListener(LineListener&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

LineListener::~LineListener() {
  if (descriptor_ >= 0) close(descriptor_);
}

int LineListener::port() const {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  if (getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &length) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

std::optional<LineSocket> LineListener::accept(std::chrono::milliseconds time) {
  if (!wait(descriptor_, POLLIN, Clock::now() + time)) return std::nullopt;
  const int descriptor = accept4(descriptor_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  return descriptor < 0 ? std::nullopt : std::optional<LineSocket>(std::in_place, descriptor);
}

}  // namespace segserve::bench
