// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "nlohmann/json_fwd.hpp"

namespace segserve::bench_report {

/// The value of "format" in what `segctl bench --json` writes.
inline constexpr std::string_view kRunFormat = "segserve-bench-1";

/// The load test that a file of `segctl bench --json` describes. Keys that this version does not know are kept. What it
/// knows has its type: reports rely on it. INVALID_ARGUMENT, with every fault by its place (the first few of many), for
/// anything else, such as a file of another format, of more than 64 MiB, or with more than 16 levels.
absl::StatusOr<nlohmann::ordered_json> parse_run(std::string_view bytes);

/// Checks JSON as parse_run does.
absl::Status check_run(const nlohmann::ordered_json& run);

}  // namespace segserve::bench_report
