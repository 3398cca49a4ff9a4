// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/metrics_listener.hpp"

#include <utility>

#include "core/base/status_macros.hpp"

namespace segserve::bench {

absl::StatusOr<std::unique_ptr<MetricsListener>> MetricsListener::start(const std::string& host,
                                                                        const std::string& port) {
  std::unique_ptr<MetricsListener> metrics(new MetricsListener());
  ASSIGN_OR_RETURN(metrics->listener_,
                   HttpListener::start(host, port, [listener = metrics.get()](const HttpRequest& request) {
                     return listener->answer(request);
                   }));
  return metrics;
}

void MetricsListener::set_page(std::function<std::string()> page) {
  const MutexLock lock(mutex_);
  if (!page && page_) last_ = page_();
  page_ = std::move(page);
}

HttpReply MetricsListener::answer(const HttpRequest& request) {
  HttpReply reply;
  if (request.path != "/metrics") {
    reply.status = "404 Not Found";
    return reply;
  }
  const MutexLock lock(mutex_);
  if (page_) last_ = page_();
  reply.content_type = "text/plain; version=0.0.4; charset=utf-8";
  reply.body = std::make_shared<const std::string>(last_);
  return reply;
}

}  // namespace segserve::bench
