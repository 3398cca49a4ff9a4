// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "prometheus/collectable.h"
#include "prometheus/metric_family.h"
#include "server/observe/service_state.hpp"

namespace segserve::server {

/// Tells at each scrape what the service does at that moment: workers, queue, memory, calls and streams. Thread-safe.
class StateMetrics final : public prometheus::Collectable {
 public:
  /// `state` is called from any thread.
  explicit StateMetrics(std::function<ServiceState()> state) : state_(std::move(state)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const std::function<ServiceState()> state_;
};

}  // namespace segserve::server
