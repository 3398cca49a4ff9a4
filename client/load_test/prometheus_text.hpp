// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace segserve::bench {

/// A value of a page of metrics.
struct MetricSample {
  std::string name;
  std::map<std::string, std::string> labels;
  double value = 0;

  /// For example `segserve_frames_total{call="stream",outcome="result"}`.
  std::string text() const;
};

/// The samples of a page in the text format of Prometheus. Comments and lines that are no samples are left out.
std::vector<MetricSample> parse_prometheus_text(std::string_view page);

}  // namespace segserve::bench
