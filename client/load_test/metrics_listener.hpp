// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/load_test/http_listener.hpp"
#include "core/base/mutex.hpp"

namespace segserve::bench {

/// Serves the page /metrics to the Prometheus that watches a load test. A server for strangers is server/metrics.
class MetricsListener {
 public:
  /// As HttpListener::start.
  static absl::StatusOr<std::unique_ptr<MetricsListener>> start(const std::string& host, const std::string& port);

  int port() const { return listener_->port(); }
  /// Serves the page that `page` makes, until another one is set; with null, the last page that was made. When this
  /// returns, the function that was set before is not running any more.
  void set_page(std::function<std::string()> page) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  MetricsListener() = default;
  HttpReply answer(const HttpRequest& request) ABSL_LOCKS_EXCLUDED(mutex_);

  Mutex mutex_;
  std::function<std::string()> page_ ABSL_GUARDED_BY(mutex_);
  std::string last_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<HttpListener> listener_;  // is destroyed first, because it calls the others
};

}  // namespace segserve::bench
