// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "prometheus/metric_family.h"

// Builds metrics whose values are read at the moment of a scrape.
namespace segserve::server {

using MetricLabels = std::vector<std::pair<std::string, std::string>>;

/// One value of a family, with its labels.
struct MetricValue {
  double value = 0;
  MetricLabels labels = {};
};

prometheus::MetricFamily gauge(const char* name, const char* help, const std::vector<MetricValue>& values);
prometheus::MetricFamily counter(const char* name, const char* help, const std::vector<MetricValue>& values);

inline prometheus::MetricFamily gauge(const char* name, const char* help, double value) {
  return gauge(name, help, std::vector<MetricValue>{{value}});
}
inline prometheus::MetricFamily counter(const char* name, const char* help, double value) {
  return counter(name, help, std::vector<MetricValue>{{value}});
}

}  // namespace segserve::server
