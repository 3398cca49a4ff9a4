// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "prometheus/collectable.h"
#include "prometheus/registry.h"
#include "server/metrics/metrics_server.hpp"
#include "server/metrics/metrics_text.hpp"
#include "server/observe/service_observer.hpp"
#include "server/observe/service_state.hpp"
#include "server/options/listen_address.hpp"

namespace segserve::server {

/// All metrics of a service: it counts frames from its construction on, and is read by Prometheus from `serve` on.
class ServiceMetrics {
 public:
  ServiceMetrics();

  /// Counts frames and streams; to be given to the service.
  const std::shared_ptr<ServiceObserver>& observer() const { return observer_; }

  /// Adds metrics of something else, before `serve`.
  void add(std::shared_ptr<prometheus::Collectable> source) { sources_.push_back(std::move(source)); }

  /// Serves /metrics until this object is destroyed. `state` is called at each scrape. Errors are those of
  /// MetricsServer::start.
  absl::Status serve(const ListenAddress& address, std::function<ServiceState()> state);

  /// The page that it serves; null before `serve`.
  const std::shared_ptr<MetricsText>& page() const { return page_; }

  /// The port at which it serves.
  int port() const { return server_->port(); }

 private:
  const std::shared_ptr<prometheus::Registry> registry_ = std::make_shared<prometheus::Registry>();
  const std::shared_ptr<ServiceObserver> observer_;
  std::vector<std::shared_ptr<prometheus::Collectable>> sources_;
  std::shared_ptr<MetricsText> page_;
  std::unique_ptr<MetricsServer> server_;
};

}  // namespace segserve::server
