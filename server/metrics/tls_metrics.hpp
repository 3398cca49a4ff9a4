// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "prometheus/collectable.h"
#include "prometheus/metric_family.h"
#include "server/tls/certificate_reloader.hpp"

namespace segserve::server {

/// Tells at each scrape when certificates end, and how often their files were read again. Thread-safe.
class TlsMetrics final : public prometheus::Collectable {
 public:
  /// `status` is called from any thread.
  explicit TlsMetrics(std::function<TlsStatus()> status) : status_(std::move(status)) {}

  std::vector<prometheus::MetricFamily> Collect() const override;

 private:
  const std::function<TlsStatus()> status_;
};

}  // namespace segserve::server
