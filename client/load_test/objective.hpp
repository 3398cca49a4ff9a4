#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/options.hpp"

namespace segserve::bench {

struct Report;

/// What a run must reach, e.g. "p99<50ms":
///
///     objective = metric ("<" | "<=" | ">" | ">=") number [unit]
///
/// Metrics: p50, p90, p99, p99.9, mean, max (latency; unit us, ms or s, required), fps (frames/s), mpoints
/// (million points/s), errors (frames without a result; unit %, required).
struct Objective {
  std::string text;
  std::string metric;
  std::string comparison;
  double bound = 0;  ///< ms for latencies, else as written
};

/// INVALID_ARGUMENT that says what is wrong and what is allowed.
absl::StatusOr<Objective> parse_objective(std::string_view text);

/// The metric of a run, in the unit of Objective::bound.
double value(const Objective& objective, const Report& report);
bool is_met(const Objective& objective, const Report& report);

}  // namespace segserve::bench
