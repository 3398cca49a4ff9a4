// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "server/metrics/metrics_text.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// Serves /metrics over HTTP/1.1 in plain text, for Prometheus, on one thread that waits for no client. Slow clients
/// keep nobody else waiting: each connection ends after two seconds, the oldest one ends when there are too many, and
/// no more than 50 answers a second are made. So the worst that a hostile client can do is to keep others from reading.
///
/// prometheus-cpp has a server, too. It gives a thread to each connection, so that a few slow clients lock out all
/// others and delay the end of the process, and it adds metrics in microseconds.
class MetricsServer {
 public:
  /// Serves the metrics of `page` from the return on, until it is destroyed. INVALID_ARGUMENT for a unix socket, and
  /// UNAVAILABLE if the address cannot be bound; both name the address.
  static absl::StatusOr<std::unique_ptr<MetricsServer>> start(const ListenAddress& address,
                                                              std::shared_ptr<MetricsText> page);

  virtual ~MetricsServer() = default;

  /// The port that it listens on.
  virtual int port() const = 0;
};

}  // namespace segserve::server
