// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "client/load_test/line_socket.hpp"

namespace segserve::bench {

/// A request of HTTP without a body.
struct HttpRequest {
  std::string path;   ///< as it was sent, without the query
  std::string query;  ///< as it was sent, without the question mark
};

struct HttpReply {
  std::string status = "200 OK";
  std::string content_type = "text/plain; charset=utf-8";
  std::string policy = "default-src 'none'; frame-ancestors 'none'";  ///< Content-Security-Policy
  std::shared_ptr<const std::string> body = nullptr;                  ///< null: none
};

/// Answers GET over HTTP/1.1, one request a connection, for the few browsers and scrapers that look at what segctl
/// does. It takes 16 connections at a time and refuses others, gives each 5 s to ask and 10 s to read the answer, and
/// reads at most 16 KiB. If it listens on loopback, it answers only requests for loopback: a page of another site that
/// gives its name the address 127.0.0.1 learns nothing.
class HttpListener {
 public:
  /// May wait, and is called by several threads.
  using Handler = std::function<HttpReply(const HttpRequest&)>;

  /// Listens on a host, an IPv6 address without brackets, and a port, 0 for any. UNAVAILABLE if that cannot be bound.
  static absl::StatusOr<std::unique_ptr<HttpListener>> start(const std::string& host, const std::string& port,
                                                             Handler handler);
  /// Waits for the connections, so that the handler must not wait any more.
  ~HttpListener();
  HttpListener(const HttpListener&) = delete;
  HttpListener& operator=(const HttpListener&) = delete;

  int port() const { return listener_.port(); }

 private:
  struct Connection {
    std::thread thread;
    std::atomic<bool> is_done{false};
  };

  HttpListener(LineListener listener, bool only_loopback, Handler handler);
  void run();
  void serve(LineSocket& browser) const;
  void join_done();

  LineListener listener_;
  const bool only_loopback_;
  const Handler handler_;
  std::list<Connection> connections_;  // of the thread
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace segserve::bench
