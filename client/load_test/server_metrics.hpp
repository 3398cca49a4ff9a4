// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/metrics_page.hpp"
#include "core/base/mutex.hpp"

namespace segserve::bench {

/// The figures about a server that its metrics tell, from the beginning to the end of a load test.
struct ServerMetrics {
  std::vector<MetricSample> before, after;
  double memory_bytes_max = 0;  ///< the largest resident memory that was seen, about once a second

  /// The growth of the samples of a name, summed over all labels but those that must have the value given.
  double growth(const std::string& name, const std::map<std::string, std::string>& labels = {}) const;
  /// The growth for each value of one label. Values whose samples did not grow are left out.
  std::map<std::string, double> growth_by(const std::string& name, const std::string& label) const;
  /// A percentile of what a histogram of the server counted meanwhile, by linear interpolation within its buckets;
  /// unset if it counted nothing.
  std::optional<double> percentile(const std::string& histogram, double percent) const;
  /// Time of one CPU for each frame that the server had a result for, in ms.
  std::optional<double> cpu_ms_per_frame() const;
};

/// Reads the metrics of a server while a load test runs.
class ServerMonitor {
 public:
  /// Reads them for the first time. Errors as of read_metrics().
  static absl::StatusOr<std::unique_ptr<ServerMonitor>> start(MetricsAddress address);
  ~ServerMonitor();
  ServerMonitor(const ServerMonitor&) = delete;
  ServerMonitor& operator=(const ServerMonitor&) = delete;

  /// The metrics since the start, or since the last call of lap(), until now. Errors as of read_metrics().
  absl::StatusOr<ServerMetrics> total() ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<ServerMetrics> lap() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  ServerMonitor(MetricsAddress address, std::vector<MetricSample> first);
  void watch() ABSL_LOCKS_EXCLUDED(mutex_);
  void look(const std::vector<MetricSample>& samples) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<ServerMetrics> since(const std::vector<MetricSample>& begin) ABSL_LOCKS_EXCLUDED(mutex_);

  const MetricsAddress address_;
  const std::vector<MetricSample> first_;
  std::vector<MetricSample> lap_began_;
  Mutex mutex_;
  CondVar stopped_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  double memory_bytes_max_ ABSL_GUARDED_BY(mutex_) = 0;
  std::thread thread_;
};

}  // namespace segserve::bench
