// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/bench_summary.hpp"

#include <cmath>

#include "fmt/format.h"
#include "fmt/ranges.h"

namespace segserve::segctl {
namespace {

/// For example "p99<50ms (reached 71.300), errors<=0% (reached 2.000)".
std::string missed_objectives(const BenchSummary& summary) {
  std::vector<std::string> missed;
  for (const bench::Objective& objective : summary.objectives) {
    const bench::Report& total = summary.result.total;
    if (is_met(objective, total)) continue;
    const double reached = value(objective, total);
    missed.push_back(std::isinf(reached) ? fmt::format("{} (frames failed)", objective.text)
                                         : fmt::format("{} (reached {:.3f})", objective.text, reached));
  }
  return fmt::format("{}", fmt::join(missed, ", "));
}

/// For example "12 times FAILED UNAVAILABLE, 3 times UNFINISHED".
std::string errors_text(const bench::Report& report) {
  std::vector<std::string> errors;
  for (const auto& [key, count] : report.errors) errors.push_back(fmt::format("{} times {}", count, key));
  return fmt::format("{}", fmt::join(errors, ", "));
}

}  // namespace

std::string BenchSummary::codec() const { return fmt::format("{}", fmt::join(codecs, ", ")); }

const char* arrivals_name(const bench::LoadOptions& load) {
  if (load.replay_speed > 0) return "recorded";
  return load.poisson ? "poisson" : "constant";
}

absl::Status verdict(const BenchSummary& summary) {
  const bench::Report& total = summary.result.total;
  if (summary.result.interrupted) return absl::CancelledError("interrupted: the figures are those of a shorter run");
  if (total.mismatches > 0) {
    return absl::InternalError(
        fmt::format("{} of {} label arrays differ from those of a local run", total.mismatches, total.verified));
  }
  if (summary.capacity && summary.capacity->low == 0) {
    return absl::FailedPreconditionError(fmt::format("no rate met {}", summary.search->text));
  }
  if (const std::string missed = missed_objectives(summary); !missed.empty()) {
    return absl::FailedPreconditionError(fmt::format("missed: {}", missed));
  }
  if (total.results == 0) {
    const std::string why = total.errors.empty() ? "none was sent" : total.errors.begin()->first;
    return absl::UnavailableError(fmt::format("no frame got a result: {}", why));
  }
  if (total.failed() > 0 && !bounds_errors(summary.objectives)) {
    return absl::UnavailableError(
        fmt::format("{} of {} frames failed ({}); an objective such as errors<=1% allows some", total.failed(),
                    total.sent, errors_text(total)));
  }
  return absl::OkStatus();
}

}  // namespace segserve::segctl
