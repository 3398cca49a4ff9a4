// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/objective.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "client/load_test/load_report.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"

namespace segserve::bench {
namespace {

enum class Kind { kLatency, kRate, kShare };

struct Metric {
  std::string_view name;
  Kind kind;
  double (*value)(const Report&);
};

/// A latency over all frames: infinite if one failed.
double with_failures(const Report& report, double milliseconds) {
  return report.latency.failed() > 0 ? std::numeric_limits<double>::infinity() : milliseconds;
}

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> kAll = {
      {"p50", Kind::kLatency, [](const Report& r) { return r.latency.percentile(50); }},
      {"p90", Kind::kLatency, [](const Report& r) { return r.latency.percentile(90); }},
      {"p95", Kind::kLatency, [](const Report& r) { return r.latency.percentile(95); }},
      {"p99", Kind::kLatency, [](const Report& r) { return r.latency.percentile(99); }},
      {"p99.9", Kind::kLatency, [](const Report& r) { return r.latency.percentile(99.9); }},
      {"p99.99", Kind::kLatency, [](const Report& r) { return r.latency.percentile(99.99); }},
      {"mean", Kind::kLatency, [](const Report& r) { return with_failures(r, r.latency.mean()); }},
      {"max", Kind::kLatency, [](const Report& r) { return with_failures(r, r.latency.max()); }},
      {"fps", Kind::kRate, [](const Report& r) { return r.frames_per_second(); }},
      {"mpoints", Kind::kRate, [](const Report& r) { return r.mpoints_per_second(); }},
      {"errors", Kind::kShare, [](const Report& r) { return r.error_percent(); }},
      {"least-share", Kind::kShare, [](const Report& r) { return r.least_share_percent(); }},
  };
  return kAll;
}

const Metric* find_metric(std::string_view name) {
  for (const Metric& metric : metrics()) {
    if (metric.name == name) return &metric;
  }
  return nullptr;
}

absl::Status wrong(std::string_view text, std::string_view why) {
  return absl::InvalidArgumentError(fmt::format("{}: {}", text, why));
}

/// The factor that turns a bound in this unit into ms or percent.
absl::StatusOr<double> unit_factor(std::string_view text, Kind kind, std::string_view unit) {
  switch (kind) {
    case Kind::kLatency:
      if (unit == "us") return 0.001;
      if (unit == "ms") return 1.0;
      if (unit == "s") return 1000.0;
      return wrong(text, fmt::format("the unit of a latency must be us, ms or s, not '{}'", unit));
    case Kind::kShare:
      if (unit == "%") return 1.0;
      return wrong(text, fmt::format("the unit of a share must be %, not '{}'", unit));
    case Kind::kRate:
      if (unit.empty()) return 1.0;
      return wrong(text, fmt::format("a rate has no unit, not '{}'", unit));
  }
  return wrong(text, "the metric is unknown");
}

absl::StatusOr<Objective> parse(std::string_view text) {
  const std::size_t at = text.find_first_of("<>");
  if (at == std::string_view::npos)
    return wrong(text, "it must be METRIC<NUMBER UNIT, for example p99<50ms; <=, > and >= are allowed as well");
  const std::size_t length = at + 1 < text.size() && text[at + 1] == '=' ? 2 : 1;
  Objective objective{std::string(text), std::string(text.substr(0, at)), std::string(text.substr(at, length)), 0};
  const Metric* metric = find_metric(objective.metric);
  if (metric == nullptr) {
    std::string names;
    for (const Metric& known : metrics()) names += fmt::format("{}{}", names.empty() ? "" : ", ", known.name);
    return wrong(text, fmt::format("'{}' is none of {}", objective.metric, names));
  }
  const std::string_view number = text.substr(at + length);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), objective.bound);
  if (error != std::errc{} || !std::isfinite(objective.bound) || objective.bound < 0) {
    return wrong(text, fmt::format("'{}' does not begin with a number of at least 0", number));
  }
  const std::string_view unit = number.substr(static_cast<std::size_t>(end - number.data()));
  ASSIGN_OR_RETURN(const double factor, unit_factor(text, metric->kind, unit));
  objective.bound *= factor;
  return objective;
}

}  // namespace

absl::StatusOr<Objective> parse_objective(std::string_view text, std::string_view flag) {
  auto objective = parse(text);
  if (objective.ok()) return objective;
  return absl::InvalidArgumentError(fmt::format("{} {}", flag, message_of(objective.status())));
}

double value(const Objective& objective, const Report& report) { return find_metric(objective.metric)->value(report); }

bool bounds_errors(const std::vector<Objective>& objectives) {
  return std::ranges::any_of(objectives, [](const Objective& each) { return each.metric == "errors"; });
}

bool is_met(const Objective& objective, const Report& report) {
  const bool is_latency = find_metric(objective.metric)->kind == Kind::kLatency;
  if (is_latency && report.latency.count() == 0) return false;  // nothing was measured
  const double reached = value(objective, report);
  if (std::isinf(reached)) return false;  // a failed frame keeps no bound of latency, not even a lower one
  if (objective.comparison == "<") return reached < objective.bound;
  if (objective.comparison == "<=") return reached <= objective.bound;
  if (objective.comparison == ">") return reached > objective.bound;
  return reached >= objective.bound;
}

}  // namespace segserve::bench
