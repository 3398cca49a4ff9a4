// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::bench {

struct Report;

/// A bound that a run must keep, for example "p99<50ms":
///
///     objective = metric ("<" | "<=" | ">" | ">=") number [unit]
///
/// Latencies are p50, p90, p95, p99, p99.9, p99.99, mean and max; they need the unit us, ms or s. A frame that failed
/// is infinitely late. Rates are fps (frames per second) and mpoints (million points per second); they have no unit.
/// Shares are errors (frames without a result) and least-share (Report::least_share_percent); they need the unit %.
struct Objective {
  std::string text;
  std::string metric;
  std::string comparison;
  double bound = 0;  ///< ms for latencies, else as written
};

/// The objective that `text` stands for; `flag` gave it. INVALID_ARGUMENT that says what is wrong and what is allowed.
absl::StatusOr<Objective> parse_objective(std::string_view text, std::string_view flag = "--objective");

/// The value of the objective's metric in a run, in the unit of Objective::bound; infinity for a latency that is one of
/// failed frames.
double value(const Objective& objective, const Report& report);
/// Whether one of them says how many frames may fail.
bool bounds_errors(const std::vector<Objective>& objectives);
/// Whether the run keeps the bound. A bound of latency is not kept if no latency was measured.
bool is_met(const Objective& objective, const Report& report);

}  // namespace segserve::bench
