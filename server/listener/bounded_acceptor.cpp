// SPDX-License-Identifier: Apache-2.0
#include "server/listener/bounded_acceptor.hpp"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <utility>

#include "server/frames/catch_exceptions.hpp"

namespace segserve::server {
namespace {

// The time without new connections after one could not be accepted.
constexpr int kPauseMs = 100;

}  // namespace

absl::StatusOr<std::unique_ptr<BoundedAcceptor>> BoundedAcceptor::start(Socket listener, std::size_t most, Take take) {
  Socket wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake.is_open()) return absl::UnavailableError("there are too many open files");
  return std::unique_ptr<BoundedAcceptor>(
      new BoundedAcceptor(std::move(listener), std::move(wake), most, std::move(take)));
}

BoundedAcceptor::BoundedAcceptor(Socket listener, Socket wake, std::size_t most, Take take)
    : listener_(std::move(listener)), wake_(std::move(wake)), most_(most), take_(std::move(take)), thread_([this] {
        run();
      }) {}

BoundedAcceptor::~BoundedAcceptor() {
  eventfd_write(wake_.descriptor(), 1);
  thread_.join();
}

void BoundedAcceptor::run() {
  while (true) {
    // Without memory for a connection, it is closed.
    const absl::Status status = catch_exceptions("accept connections", [this] {
      while (wait()) pauses_ = !accept_all();
      return absl::OkStatus();
    });
    if (status.ok()) return;
  }
}

bool BoundedAcceptor::wait() {
  polled_.clear();
  polled_.push_back({wake_.descriptor(), POLLIN, 0});
  for (const Socket& connection : connections_) polled_.push_back({connection.descriptor(), 0, 0});
  if (!pauses_) polled_.push_back({listener_.descriptor(), POLLIN, 0});
  poll(polled_.data(), polled_.size(), pauses_ ? kPauseMs : -1);
  auto result = polled_.begin() + 1;
  std::erase_if(connections_, [&result](const Socket&) { return (result++->revents & (POLLHUP | POLLERR)) != 0; });
  return polled_.front().revents == 0;
}

bool BoundedAcceptor::accept_all() {
  for (std::size_t i = 0; i < most_; ++i) {
    Socket connection(accept4(listener_.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!connection.is_open()) return errno == EAGAIN || errno == EWOULDBLOCK || errno == ECONNABORTED;
    watch(std::move(connection));
  }
  return true;
}

void BoundedAcceptor::watch(Socket connection) {
  Socket duplicate(fcntl(connection.descriptor(), F_DUPFD_CLOEXEC, 0));
  if (!duplicate.is_open()) return;
  while (connections_.size() >= most_) {
    shutdown(connections_.front().descriptor(), SHUT_RDWR);
    connections_.pop_front();
  }
  connections_.push_back(std::move(duplicate));
  take_(std::move(connection));
}

}  // namespace segserve::server
