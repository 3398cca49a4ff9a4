// SPDX-License-Identifier: Apache-2.0
#include "server/listener/bounded_acceptor.hpp"

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <memory>
#include <utility>

#include "server/frames/catch_exceptions.hpp"
#include "server/scheduling/client_address.hpp"

namespace segserve::server {
namespace {

// The time without new connections after one could not be accepted, and between two looks at those that are held.
constexpr int kPauseMs = 100;

/// Ends a connection at once. After a mere `shutdown` gRPC would still read what waits in the system, which may be
/// thousands of calls, and a client that writes would wait for room instead of learning of the end.
void reset(int connection) {
  const sockaddr nobody{.sa_family = AF_UNSPEC, .sa_data = {}};
  if (connect(connection, &nobody, sizeof nobody) != 0) shutdown(connection, SHUT_RDWR);
}

}  // namespace

absl::StatusOr<std::unique_ptr<BoundedAcceptor>> BoundedAcceptor::start(std::vector<Socket> listeners, std::size_t most,
                                                                        Take take, Holds holds) {
  Socket wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake.is_open()) return absl::UnavailableError("there are too many open files");
  return std::unique_ptr<BoundedAcceptor>(
      new BoundedAcceptor(std::move(listeners), std::move(wake), most, std::move(take), std::move(holds)));
}

BoundedAcceptor::BoundedAcceptor(std::vector<Socket> listeners, Socket wake, std::size_t most, Take take, Holds holds)
    : listeners_(std::move(listeners)),
      wake_(std::move(wake)),
      most_(most),
      take_(std::move(take)),
      holds_(std::move(holds)),
      thread_([this] { run(); }) {}

void BoundedAcceptor::close() {
  if (!thread_.joinable()) return;
  eventfd_write(wake_.descriptor(), 1);
  thread_.join();
  listeners_.clear();
  held_.clear();
}

void BoundedAcceptor::end(const std::string& name) {
  const MutexLock lock(mutex_);
  const auto found = descriptors_.find(name);
  if (found == descriptors_.end()) return;
  reset(found->second);
  descriptors_.erase(found);
}

void BoundedAcceptor::run() {
  while (true) {
    // Without memory for a connection, it is closed.
    const absl::Status status = catch_exceptions("accept connections", [this] {
      while (wait()) {
        release_held();
        pauses_ = !accept_all();
      }
      return absl::OkStatus();
    });
    if (status.ok()) return;
  }
}

bool BoundedAcceptor::wait() {
  polled_.clear();
  polled_.push_back({wake_.descriptor(), POLLIN, 0});
  for (const Connection& each : connections_) polled_.push_back({each.duplicate.descriptor(), 0, 0});
  if (!pauses_) {
    for (const Socket& listener : listeners_) polled_.push_back({listener.descriptor(), POLLIN, 0});
  }
  poll(polled_.data(), polled_.size(), pauses_ || !held_.empty() ? kPauseMs : -1);
  auto result = polled_.begin() + 1;
  for (auto each = connections_.begin(); each != connections_.end(); ++result) {
    const bool has_ended = (result->revents & (POLLHUP | POLLERR)) != 0;
    each = has_ended ? forget(each) : std::next(each);
  }
  return polled_.front().revents == 0;
}

bool BoundedAcceptor::accept_all() {
  bool all_accepted = true;
  for (const Socket& listener : listeners_) all_accepted = accept_all(listener) && all_accepted;
  return all_accepted;
}

bool BoundedAcceptor::accept_all(const Socket& listener) {
  for (std::size_t i = 0; i < most_; ++i) {
    Socket connection(accept4(listener.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!connection.is_open()) return errno == EAGAIN || errno == EWOULDBLOCK || errno == ECONNABORTED;
    ++accepted_;
    take(std::move(connection));
  }
  return true;
}

void BoundedAcceptor::release_held() {
  std::list<Socket> held;
  held.swap(held_);
  for (Socket& connection : held) take(std::move(connection));
}

void BoundedAcceptor::take(Socket connection) {
  const std::string peer = peer_name(connection.descriptor());
  std::string address = client_address(peer);
  if (!holds_(address)) return watch(std::move(connection), std::move(address), connection_name(peer));
  if (held_.size() >= most_) held_.pop_front();
  held_.push_back(std::move(connection));
}

void BoundedAcceptor::watch(Socket connection, std::string address, std::string name) {
  Socket duplicate(fcntl(connection.descriptor(), F_DUPFD_CLOEXEC, 0));
  if (!duplicate.is_open()) return;
  ++counts_[address];
  {
    const MutexLock lock(mutex_);
    descriptors_[name] = duplicate.descriptor();
  }
  connections_.push_back({std::move(duplicate), std::move(address), std::move(name)});
  if (connections_.size() > most_) end_one();
  take_(std::move(connection));
}

void BoundedAcceptor::end_one() {
  const auto most = std::ranges::max_element(counts_, {}, [](const auto& each) { return each.second; });
  const auto oldest = std::ranges::find(connections_, most->first, &Connection::address);
  shutdown(oldest->duplicate.descriptor(), SHUT_RDWR);
  forget(oldest);
}

std::list<BoundedAcceptor::Connection>::iterator BoundedAcceptor::forget(std::list<Connection>::iterator connection) {
  const auto count = counts_.find(connection->address);
  if (--count->second == 0) counts_.erase(count);
  {
    const MutexLock lock(mutex_);
    const auto found = descriptors_.find(connection->name);
    const bool is_same = found != descriptors_.end() && found->second == connection->duplicate.descriptor();
    if (is_same) descriptors_.erase(found);
  }
  return connections_.erase(connection);
}

}  // namespace segserve::server
