// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "client/segctl/bench_summary.hpp"
#include "nlohmann/json_fwd.hpp"

namespace segserve::segctl {

/// One object, as docs/load_testing.md describes it. Figures that are computed from results are null if there is no
/// result, and latencies that are those of failed frames.
nlohmann::ordered_json to_json(const BenchSummary& summary);

}  // namespace segserve::segctl
