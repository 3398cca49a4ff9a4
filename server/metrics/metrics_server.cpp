// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/metrics_server.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/listener/file_descriptors.hpp"
#include "server/listener/socket.hpp"
#include "server/metrics/http_answer.hpp"

namespace segserve::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostConnections = 64;
constexpr std::chrono::seconds kConnectionTime{2};
// The time without new connections after one could not be taken, for example because there are too many open files.
constexpr std::chrono::milliseconds kPause{100};

/// A client from its connection to the end of its answer.
struct Connection {
  Socket socket;
  Clock::time_point end;  // it is cut off then
  std::string received, answer;
  std::size_t sent = 0;  // of the answer
};

class PollingServer final : public MetricsServer {
 public:
  /// `wake` is an eventfd.
  PollingServer(Socket listener, Socket wake, std::shared_ptr<MetricsText> page)
      : listener_(std::move(listener)), wake_(std::move(wake)), page_(std::move(page)), thread_([this] { run(); }) {}
  PollingServer(const PollingServer&) = delete;
  PollingServer& operator=(const PollingServer&) = delete;
  ~PollingServer() override {
    eventfd_write(wake_.descriptor(), 1);
    thread_.join();
  }

  int port() const override { return port_of(listener_); }

 private:
  void run();
  /// Waits until there is something to do; false if the server shall end.
  bool wait(Clock::time_point now);
  void accept_all(Clock::time_point now);
  /// Reads and writes as much as is possible now; false when the connection is over.
  bool advance(Connection& connection);

  const Socket listener_, wake_;
  const std::shared_ptr<MetricsText> page_;
  const std::size_t most_ = connections_beside_grpc(kMostConnections);
  std::list<Connection> connections_;  // the oldest first
  std::vector<pollfd> polled_;
  Clock::time_point accept_after_{};
  std::thread thread_;
};

void PollingServer::run() {
  while (true) {
    // Without memory for something, its client is cut off in the end.
    const absl::Status status = catch_exceptions("serve metrics", [this]() -> absl::Status {
      while (wait(Clock::now())) {
        const Clock::time_point now = Clock::now();
        if (now >= accept_after_) accept_all(now);
        std::erase_if(connections_,
                      [&](Connection& connection) { return now >= connection.end || !advance(connection); });
      }
      return absl::OkStatus();
    });
    if (status.ok()) return;
    connections_.clear();
  }
}

bool PollingServer::wait(Clock::time_point now) {
  polled_.clear();
  polled_.push_back({wake_.descriptor(), POLLIN, 0});
  Clock::time_point until = now + std::chrono::hours(1);
  if (now >= accept_after_) {
    polled_.push_back({listener_.descriptor(), POLLIN, 0});
  } else {
    until = accept_after_;
  }
  for (const Connection& connection : connections_) {
    const bool writes = !connection.answer.empty();
    polled_.push_back({connection.socket.descriptor(), static_cast<short>(writes ? POLLOUT : POLLIN), 0});
    until = std::min(until, connection.end);
  }
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(until - now).count();
  poll(polled_.data(), polled_.size(), std::max(0, static_cast<int>(milliseconds)));
  return polled_.front().revents == 0;
}

void PollingServer::accept_all(Clock::time_point now) {
  for (std::size_t i = 0; i < most_; ++i) {
    Socket socket(accept4(listener_.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!socket.is_open()) {
      const bool is_none_left = errno == EAGAIN || errno == EWOULDBLOCK;
      if (!is_none_left) accept_after_ = now + kPause;
      return;
    }
    if (connections_.size() >= most_) connections_.pop_front();
    connections_.push_back({std::move(socket), now + kConnectionTime, {}, {}});
  }
}

bool PollingServer::advance(Connection& connection) {
  const int descriptor = connection.socket.descriptor();
  while (connection.answer.empty()) {
    std::array<char, 2048> bytes;
    const ssize_t count = recv(descriptor, bytes.data(), bytes.size(), 0);
    if (count <= 0) return count < 0 && (errno == EAGAIN || errno == EINTR);
    connection.received.append(bytes.data(), static_cast<std::size_t>(count));
    if (auto answer = http_answer(connection.received, [&] { return page_->text(); })) {
      connection.answer = *std::move(answer);
    }
  }
  while (connection.sent < connection.answer.size()) {
    const ssize_t count = send(descriptor, connection.answer.data() + connection.sent,
                               connection.answer.size() - connection.sent, MSG_NOSIGNAL);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    connection.sent += static_cast<std::size_t>(count);
  }
  return false;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsServer>> MetricsServer::start(const ListenAddress& address,
                                                                    std::shared_ptr<MetricsText> page) {
  if (address.is_unix) return absl::InvalidArgumentError("metrics are not served on a unix socket");
  absl::StatusOr<Socket> listener = listen_at(address);
  if (!listener.ok()) {
    const std::string place = with_port(address, std::stoi(address.port));
    return absl::UnavailableError(fmt::format("cannot serve metrics on {}: {}", place, message_of(listener.status())));
  }
  Socket wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake.is_open()) return absl::UnavailableError("cannot serve metrics: there are too many open files");
  return std::make_unique<PollingServer>(*std::move(listener), std::move(wake), std::move(page));
}

}  // namespace segserve::server
