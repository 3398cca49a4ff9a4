// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "client/load_test/load_report.hpp"

namespace segserve::bench {

/// The side of a load test's client in the text format of Prometheus: the frames of the measured window so far by
/// outcome, errors, a histogram of latencies, bytes, and what this process takes of the machine.
std::string client_metrics_text(const Report& report);

}  // namespace segserve::bench
