// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/status/statusor.h"
#include "server/http/http_handler.hpp"
#include "server/http/http_tls.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// The limits of connections to a server of HTTP.
struct HttpLimits {
  std::size_t connections = 512;  ///< one more ends the one that has been idle for longest
  std::size_t header_bytes = std::size_t{16} * 1024;
  std::chrono::milliseconds header_time{10'000};      ///< for the handshake of TLS, and then for all of a header
  std::chrono::milliseconds keep_alive_time{30'000};  ///< from an answer to the end of the next header
};

/// A server of HTTP/1.1, in plain text or by TLS. Two threads serve all connections and wait for none, so that slow
/// clients keep nobody else waiting. Each step of a connection has its time: handshake, header, every part of a body,
/// every part of an answer.
class HttpServer {
 public:
  /// Serves from the return on. `tls` is null for plain text. INVALID_ARGUMENT for a unix socket, UNAVAILABLE if the
  /// address cannot be bound. The handler must outlive the server.
  static absl::StatusOr<std::unique_ptr<HttpServer>> start(const ListenAddress& address, HttpHandler& handler,
                                                           std::unique_ptr<HttpTls> tls, const HttpLimits& limits = {});

  /// Closes as `close` does, and waits until all uploads are gone, which must have been ended before.
  virtual ~HttpServer() = default;

  virtual int port() const = 0;
  /// The number of connections that were accepted so far.
  virtual std::uint64_t accepted() const = 0;
  /// Takes no more connections, and cuts those that there are.
  virtual void close() = 0;
};

}  // namespace segserve::server
