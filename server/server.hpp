// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/frames/segmentation_backend.hpp"
#include "server/listener/watched_listener.hpp"
#include "server/observe/service_observer.hpp"
#include "server/options/server_options.hpp"
#include "server/tls/certificate_reloader.hpp"

namespace segserve::server {

/// A running server: the segmentation service, grpc.health.v1 and, if wanted, reflection on one address.
///
///     auto server = Server::start({.listen = "127.0.0.1:0"});
///     if (!server.ok()) return server.status();
///     ...  // clients connect to (*server)->address()
///     (*server)->stop();
class Server {
 public:
  /// Listens, and serves from the return on. The observers learn of every frame and every stream. INVALID_ARGUMENT
  /// names every wrong option, or the fault of a file of TLS; UNAVAILABLE says why the address cannot be bound.
  static absl::StatusOr<std::unique_ptr<Server>> start(ServerOptions options,
                                                       const BackendFactory& make_backend = core_backend_factory(),
                                                       ServiceObservers observers = {});

  /// Reads the files of tokens and keys that the options name, and tells every fault of them. OK if a server would
  /// start with them.
  static absl::Status check_access_files(const ServerOptions& options);

  /// Stops as `stop` does.
  virtual ~Server() = default;

  /// The options that are in effect: what was left to the server is filled in.
  virtual const ServerOptions& options() const = 0;
  /// The address that clients connect to, with the port that was picked for port 0.
  virtual const std::string& address() const = 0;
  /// The port; 0 for a unix socket.
  virtual int port() const = 0;
  /// The port of ServerOptions::health_listen; 0 for a unix socket or none.
  virtual int health_port() const = 0;
  /// The port of ServerOptions::metrics_listen; 0 without it.
  virtual int metrics_port() const = 0;
  /// The port of ServerOptions::http; 0 without it.
  virtual int http_port() const = 0;
  /// The addresses of ServerOptions::listen, health_listen and http at which it listens.
  virtual std::vector<WatchedListener> listeners() const = 0;
  /// Unary calls that wait or are computed, and open streams.
  virtual std::size_t calls() const = 0;

  /// Whether "liveness" serves. It does from the start.
  virtual void set_alive(bool alive) = 0;

  /// The certificates in use; nothing without TLS.
  virtual std::optional<TlsStatus> tls_status() const = 0;

  /// Health turns NOT_SERVING except for "liveness", and new calls are refused with UNAVAILABLE (DRAINING). Calls in
  /// flight finish within the grace period or are cancelled at its end; then the server closes. Returns true if none
  /// was cancelled. Must not be called from a signal handler. A second call does nothing.
  virtual bool stop() = 0;
};

}  // namespace segserve::server
