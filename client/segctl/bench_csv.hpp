// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/load_test/timeline.hpp"

namespace segserve::segctl {

/// The timeline as a table: a line with the names of the columns, which are those of the JSON, and a line for each
/// interval. A figure that is null in JSON is empty.
std::string bench_csv(const std::vector<bench::TimelineEntry>& timeline);

}  // namespace segserve::segctl
