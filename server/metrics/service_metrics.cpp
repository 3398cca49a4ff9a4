// SPDX-License-Identifier: Apache-2.0
#include "server/metrics/service_metrics.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "server/metrics/frame_metrics.hpp"
#include "server/metrics/process_metrics.hpp"
#include "server/metrics/state_metrics.hpp"

namespace segserve::server {

ServiceMetrics::ServiceMetrics()
    : observer_(std::make_shared<FrameMetrics>(registry_)), sources_({registry_, std::make_shared<ProcessMetrics>()}) {}

absl::Status ServiceMetrics::serve(const ListenAddress& address, std::function<ServiceState()> state) {
  add(std::make_shared<StateMetrics>(std::move(state)));
  page_ = std::make_shared<MetricsText>(std::move(sources_));
  ASSIGN_OR_RETURN(server_, MetricsServer::start(address, page_));
  return absl::OkStatus();
}

}  // namespace segserve::server
