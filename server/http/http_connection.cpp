// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_connection.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <map>
#include <utility>

#include "server/scheduling/client_address.hpp"

namespace segserve::server {

HttpConnection::HttpConnection(boost::asio::any_io_executor executor, std::string peer)
    : executor_(std::move(executor)),
      peer_(std::move(peer)),
      address_(client_address(peer_)),
      since_(std::chrono::steady_clock::now()) {}

void HttpConnection::cut(const std::shared_ptr<HttpConnection>& connection) {
  boost::asio::post(connection->executor_, [connection] {
    connection->is_cut_ = true;
    if (connection->stream_ != nullptr) connection->stream_->close();
  });
}

void HttpConnection::enter(Phase phase) {
  phase_ = phase;
  since_ = std::chrono::steady_clock::now();
}

void HttpConnection::attach(boost::beast::tcp_stream* stream) {
  stream_ = stream;
  if (stream != nullptr && is_cut_) stream->close();
}

HttpConnections::List::iterator HttpConnections::least_needed() {
  using Phase = HttpConnection::Phase;
  std::map<std::string, std::size_t> held;
  for (const auto& connection : connections_) ++held[connection->address()];
  auto least = connections_.end();
  // Idle ones first, then those of the address with most connections, then the oldest. A client that has just come is
  // not idle, although its request is still on its way.
  static constexpr std::chrono::seconds kMoment{1};
  const auto now = std::chrono::steady_clock::now();
  const auto rank = [&held, now](const HttpConnection& connection) {
    const bool is_idle = connection.phase() == Phase::kIdle && now - connection.since() >= kMoment;
    return std::make_pair(is_idle ? 1 : 0, is_idle ? 0 : held.at(connection.address()));
  };
  for (auto each = connections_.begin(); each != connections_.end(); ++each) {
    const bool is_better = least == connections_.end() || rank(**each) > rank(**least) ||
                           (rank(**each) == rank(**least) && (*each)->since() < (*least)->since());
    if (is_better) least = each;
  }
  return least;
}

bool HttpConnections::add(const std::shared_ptr<HttpConnection>& connection, std::size_t most) {
  const MutexLock lock(mutex_);
  if (is_closed_) return false;
  if (connections_.size() >= most) {
    const auto least = least_needed();
    HttpConnection::cut(*least);
    connections_.erase(least);
  }
  connections_.push_back(connection);
  return true;
}

void HttpConnections::remove(const HttpConnection& connection) {
  const MutexLock lock(mutex_);
  std::erase_if(connections_, [&connection](const auto& each) { return each.get() == &connection; });
}

void HttpConnections::close() {
  List cut;
  {
    const MutexLock lock(mutex_);
    is_closed_ = true;
    cut.swap(connections_);
  }
  for (const auto& connection : cut) HttpConnection::cut(connection);
}

}  // namespace segserve::server
