// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nlohmann/json_fwd.hpp"

// Under which conditions a load test runs, for its report.
namespace segserve::segctl {

/// The machine: its name, CPUs, memory, kernel, and its load average of the last minute. What it does not tell is null.
nlohmann::ordered_json host_json();
/// Version, compiler and build type of this program.
nlohmann::ordered_json client_build_json();
/// The words behind "bench" on the command line of this process, as they are.
std::vector<std::string> bench_words();
/// The words of the command line of this process. Files that hold tokens or keys are left out.
nlohmann::ordered_json command_line_json();
/// The time by the wall clock, in UTC, e.g. "2026-11-29T15:30:00Z".
std::string utc_time(double seconds_since_epoch);

}  // namespace segserve::segctl
