// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nlohmann/json_fwd.hpp"

namespace segserve::bench_report {

/// A few lines about a load test that check_run accepts, for people.
std::string to_text(const nlohmann::ordered_json& run);

}  // namespace segserve::bench_report
