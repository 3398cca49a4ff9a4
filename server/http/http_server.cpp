// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_server.hpp"

#include <array>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <string>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/http/http_connection.hpp"
#include "server/http/http_session.hpp"
#include "server/listener/socket.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

namespace net = boost::asio;
using Tcp = net::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kThreads = 2;
// The time without new connections after one could not be taken, for example because there are too many open files.
constexpr std::chrono::milliseconds kPause{100};

/// Lets a connection be cut as long as its stream is there.
class Attachment {
 public:
  Attachment(HttpConnection& connection, boost::beast::tcp_stream& stream) : connection_(connection) {
    connection_.attach(&stream);
  }
  Attachment(const Attachment&) = delete;
  Attachment& operator=(const Attachment&) = delete;
  ~Attachment() { connection_.attach(nullptr); }

 private:
  HttpConnection& connection_;
};

class BeastServer final : public HttpServer {
 public:
  BeastServer(HttpHandler& handler, std::unique_ptr<HttpTls> tls, const HttpLimits& limits)
      : handler_(handler), tls_(std::move(tls)), limits_(limits), acceptor_(net::make_strand(io_)) {}
  BeastServer(const BeastServer&) = delete;
  BeastServer& operator=(const BeastServer&) = delete;
  ~BeastServer() override {
    close();
    work_.reset();
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

  /// `listener` is a socket that listens.
  void serve(const Socket& listener, bool is_ipv6);

  int port() const override { return port_; }
  std::uint64_t accepted() const override { return accepted_; }
  void close() override;

 private:
  net::awaitable<void> accept();
  net::awaitable<void> serve_plain(Tcp::socket socket, std::shared_ptr<HttpConnection> connection);
  net::awaitable<void> serve_tls(Tcp::socket socket, std::shared_ptr<HttpConnection> connection);
  void begin(Tcp::socket socket);
  void run();

  HttpHandler& handler_;
  const std::unique_ptr<HttpTls> tls_;
  const HttpLimits limits_;
  net::io_context io_;
  net::executor_work_guard<net::io_context::executor_type> work_{io_.get_executor()};
  Tcp::acceptor acceptor_;
  int port_ = 0;
  std::atomic<std::uint64_t> accepted_{0};
  HttpConnections connections_;
  std::array<std::thread, kThreads> threads_;
};

void BeastServer::serve(const Socket& listener, bool is_ipv6) {
  port_ = port_of(listener);
  acceptor_.assign(is_ipv6 ? Tcp::v6() : Tcp::v4(), dup(listener.descriptor()));
  net::co_spawn(acceptor_.get_executor(), accept(), net::detached);
  for (std::thread& thread : threads_) thread = std::thread([this] { run(); });
}

void BeastServer::run() {
  while (true) {
    // An exception ends the connection at whose step it was thrown, and no other.
    const absl::Status status = catch_exceptions("serve HTTP", [this] {
      io_.run();
      return absl::OkStatus();
    });
    if (status.ok()) return;
  }
}

net::awaitable<void> BeastServer::accept() {
  net::steady_timer pause(acceptor_.get_executor());
  boost::system::error_code error;
  while (acceptor_.is_open()) {
    // Each connection has an order of its own in which its steps come, on whichever thread.
    Tcp::socket socket(net::make_strand(io_));
    co_await acceptor_.async_accept(socket, net::redirect_error(net::use_awaitable, error));
    if (!acceptor_.is_open()) co_return;
    if (error) {
      pause.expires_after(kPause);
      co_await pause.async_wait(net::redirect_error(net::use_awaitable, error));
    } else {
      ++accepted_;
      begin(std::move(socket));
    }
  }
}

void BeastServer::begin(Tcp::socket socket) {
  const absl::Status status = catch_exceptions("take a connection", [&] {
    const auto executor = socket.get_executor();
    boost::system::error_code error;
    socket.set_option(Tcp::no_delay(true), error);
    const auto connection = std::make_shared<HttpConnection>(executor, peer_name(socket.native_handle()));
    if (!connections_.add(connection, limits_.connections)) return absl::OkStatus();
    auto steps = tls_ ? serve_tls(std::move(socket), connection) : serve_plain(std::move(socket), connection);
    net::co_spawn(executor, std::move(steps), [this, connection](const std::exception_ptr& thrown) {
      connections_.remove(*connection);
      if (!thrown) return;
      const absl::Status failed =
          catch_exceptions("serve a connection", [&thrown]() -> absl::Status { std::rethrow_exception(thrown); });
      failed.IgnoreError();  // it is in the log
    });
    return absl::OkStatus();
  });
  status.IgnoreError();  // it is in the log, and the connection is closed
}

net::awaitable<void> BeastServer::serve_plain(Tcp::socket socket, std::shared_ptr<HttpConnection> connection) {
  boost::beast::tcp_stream stream(std::move(socket));
  const Attachment attachment(*connection, stream);
  HttpSession session(stream, *connection, "", handler_, limits_);
  co_await session.run();
}

net::awaitable<void> BeastServer::serve_tls(Tcp::socket socket, std::shared_ptr<HttpConnection> connection) {
  auto context = tls_->context();
  if (!context.ok()) {
    spdlog::error("a connection of HTTP was refused: {}", message_of(context.status()));
    co_return;
  }
  net::ssl::context owner(context->release());
  boost::beast::ssl_stream<boost::beast::tcp_stream> stream(std::move(socket), owner);
  const Attachment attachment(*connection, boost::beast::get_lowest_layer(stream));
  boost::system::error_code error;
  boost::beast::get_lowest_layer(stream).expires_after(limits_.header_time);
  co_await stream.async_handshake(net::ssl::stream_base::server, net::redirect_error(net::use_awaitable, error));
  if (error) co_return;
  HttpSession session(stream, *connection, certificate_name(*stream.native_handle()), handler_, limits_);
  co_await session.run();
}

void BeastServer::close() {
  net::post(acceptor_.get_executor(), [this] {
    boost::system::error_code error;
    acceptor_.close(error);
  });
  connections_.close();
}

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::start(const ListenAddress& address, HttpHandler& handler,
                                                              std::unique_ptr<HttpTls> tls, const HttpLimits& limits) {
  if (address.is_unix) return absl::InvalidArgumentError("HTTP is not served on a unix socket");
  const absl::StatusOr<Socket> listener = listen_at(address);
  if (!listener.ok()) {
    const std::string place = with_port(address, std::stoi(address.port));
    return absl::UnavailableError(fmt::format("cannot serve HTTP on {}: {}", place, message_of(listener.status())));
  }
  auto server = std::make_unique<BeastServer>(handler, std::move(tls), limits);
  server->serve(*listener, is_ipv6(*listener));
  return server;
}

}  // namespace segserve::server
