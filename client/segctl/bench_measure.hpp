// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/load_test/load.hpp"
#include "client/segctl/bench_arguments.hpp"
#include "client/segctl/bench_summary.hpp"

namespace segserve::segctl {

/// Runs the load that the flags ask for, with all that goes with it: progress on a terminal, a line for each interval
/// of a soak, faults, and the metrics of the server. Ctrl-C ends it early. Fills in what was measured, and the HDR log
/// if it is wanted. Errors as of bench::run_plan, and if there are no metrics where they should be.
absl::Status measure(const BenchArguments& arguments, const bench::FrameSource& source, BenchSummary& summary,
                     std::string& hdr_log);

}  // namespace segserve::segctl
