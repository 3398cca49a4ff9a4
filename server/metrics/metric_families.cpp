// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/metric_families.hpp"

namespace segserve::server {
namespace {

prometheus::MetricFamily family(const char* name, const char* help, prometheus::MetricType type,
                                const std::vector<MetricValue>& values) {
  prometheus::MetricFamily family{name, help, type, {}};
  for (const MetricValue& value : values) {
    prometheus::ClientMetric metric;
    for (const auto& [label, text] : value.labels) metric.label.push_back({label, text});
    (type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value) = value.value;
    family.metric.push_back(std::move(metric));
  }
  return family;
}

}  // namespace

prometheus::MetricFamily gauge(const char* name, const char* help, const std::vector<MetricValue>& values) {
  return family(name, help, prometheus::MetricType::Gauge, values);
}

prometheus::MetricFamily counter(const char* name, const char* help, const std::vector<MetricValue>& values) {
  return family(name, help, prometheus::MetricType::Counter, values);
}

}  // namespace segserve::server
