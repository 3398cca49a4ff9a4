#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/frames/segmentation_backend.hpp"
#include "server/options/server_options.hpp"

namespace segserve::server {

/// Every fault of the options at once, by the names of their flags; empty if they are valid.
std::vector<FieldViolation> violations(const ServerOptions& options);

/// A running server: the segmentation service, grpc.health.v1 and reflection on one address.
class Server {
 public:
  /// Listens and serves from the return on. INVALID_ARGUMENT for wrong options (all of them named),
  /// UNAVAILABLE if the address cannot be bound.
  static absl::StatusOr<std::unique_ptr<Server>> start(ServerOptions options,
                                                       const BackendFactory& make_backend = core_backend_factory());

  /// Stops as `stop` does.
  virtual ~Server() = default;

  /// The address that clients connect to, with the port that was picked for port 0.
  virtual const std::string& address() const = 0;
  /// The port; 0 for a unix socket.
  virtual int port() const = 0;
  /// Calls of Segment in flight, waiting or computed.
  virtual std::size_t calls() const = 0;

  /// Health turns NOT_SERVING, new calls are refused with UNAVAILABLE (DRAINING), those in flight finish within
  /// the grace period or are cancelled at its end; then the server closes. Returns true if none was cancelled.
  /// Not from a signal handler. A second call does nothing.
  virtual bool stop() = 0;
};

}  // namespace segserve::server
