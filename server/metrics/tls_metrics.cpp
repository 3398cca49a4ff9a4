// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/tls_metrics.hpp"

#include <chrono>

#include "server/metrics/metric_families.hpp"

namespace segserve::server {
namespace {

double since_1970(std::chrono::sys_seconds time) { return static_cast<double>(time.time_since_epoch().count()); }

}  // namespace

std::vector<prometheus::MetricFamily> TlsMetrics::Collect() const {
  const TlsStatus status = status_();
  std::vector<MetricValue> ends{{since_1970(status.certificate_end), {{"certificate", "server"}}}};
  if (status.client_ca_end) ends.push_back({since_1970(*status.client_ca_end), {{"certificate", "client_ca"}}});
  return {gauge("segserve_tls_certificate_end_timestamp_seconds",
                "When the certificate, or one of its chain, ends; seconds since 1970.", ends),
          counter("segserve_tls_reloads_total", "Changed files of TLS that were taken, or refused for their faults.",
                  {{static_cast<double>(status.reloads), {{"outcome", "taken"}}},
                   {static_cast<double>(status.failed_reloads), {{"outcome", "refused"}}}})};
}

}  // namespace segserve::server
