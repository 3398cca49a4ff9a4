// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/load_test/server_metrics.hpp"
#include "nlohmann/json_fwd.hpp"

namespace segserve::segctl {

/// Writes what a server told about itself during a load test. Figures that it did not tell are null.
nlohmann::ordered_json server_metrics_json(const bench::ServerMetrics& metrics);

}  // namespace segserve::segctl
