// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "prometheus/collectable.h"
#include "prometheus/metric_family.h"

namespace segserve::server {

/// Tells at each scrape what this process takes of the machine, under the names that all client libraries of Prometheus
/// share, and which build it is. What the system does not tell is left out. Thread-safe.
class ProcessMetrics final : public prometheus::Collectable {
 public:
  std::vector<prometheus::MetricFamily> Collect() const override;
};

}  // namespace segserve::server
