// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nlohmann/json_fwd.hpp"

namespace segserve::bench_report {

/// The reasons why the figures of two load tests, which check_run accepts, cannot be compared: each is a sentence about
/// something that decides what was measured and differs, such as the schedule, the clients, the codecs, the frames or
/// the options of the method. Empty if they may be compared. The duration, and where results were saved, do not count.
std::vector<std::string> reasons_not_to_compare(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);

/// Names what a reader should know before comparing two load tests: another machine, or a finding about either of them.
std::vector<std::string> caveats(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);

}  // namespace segserve::bench_report
