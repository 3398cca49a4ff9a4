// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/prometheus_text.hpp"

namespace segserve::bench {

/// Where a page of metrics is.
struct MetricsAddress {
  std::string host, port, path;
};

/// "http://HOST:PORT/PATH", "HOST:PORT" or "[IPv6]:PORT"; without a path, /metrics. INVALID_ARGUMENT if it is none of
/// these: TLS is not spoken.
absl::StatusOr<MetricsAddress> parse_metrics_address(std::string_view text);

/// Gets the page by HTTP and reads its samples. UNAVAILABLE if no server answers in time, or not with such a page of at
/// most 16 MiB.
absl::StatusOr<std::vector<MetricSample>> read_metrics(const MetricsAddress& address,
                                                       std::chrono::milliseconds timeout);

}  // namespace segserve::bench
