// SPDX-License-Identifier: Apache-2.0
#include "client/bench_report/run_diff.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "client/bench_report/comparable.hpp"
#include "client/bench_report/measured_run.hpp"
#include "client/bench_report/resampling.hpp"

namespace segserve::bench_report {
namespace {

using Values = std::vector<double>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double relative_change(double a, double b) {
  if (a == b) return 0;
  if (std::isinf(a)) return -1;
  return a == 0 ? kInfinity : (b - a) / a;
}

/// Gives `row` its change and, if there are replicates of both figures, the interval of the change.
void set_change(DiffRow& row, Values a, Values b, double confidence) {
  const auto change = [&row](double from, double to) { return row.is_share ? to - from : relative_change(from, to); };
  row.change = change(row.a, row.b);
  if (a.empty() || b.empty()) {
    row.method = "none";
    return;
  }
  Values changes;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) changes.push_back(change(a[i], b[i]));
  std::ranges::sort(changes);
  const auto at = [&changes](double share) {
    return changes[static_cast<std::size_t>(std::lround(share * static_cast<double>(changes.size() - 1)))];
  };
  row.low = at((1 - confidence) / 2);
  row.high = at((1 + confidence) / 2);
}

/// Judges the change of a figure of which less is better if `sign` is 1, or more if it is -1. It must be more than
/// `allowed`.
DiffVerdict judge(const DiffRow& row, double sign, double allowed) {
  const double worse = sign * row.change;
  const double low = sign > 0 ? row.low.value_or(row.change) : -row.high.value_or(row.change);
  const double high = sign > 0 ? row.high.value_or(row.change) : -row.low.value_or(row.change);
  if (worse > allowed && low > 0) return DiffVerdict::kWorse;
  if (-worse > allowed && high < 0) return DiffVerdict::kBetter;
  return low >= -allowed && high <= allowed ? DiffVerdict::kSame : DiffVerdict::kUnclear;
}

class Comparison {
 public:
  Comparison(const MeasuredRun& a, const MeasuredRun& b, const DiffOptions& options)
      : a_(a), b_(b), options_(options), random_(options.seed) {}

  void compare_throughput() {
    if (!a_.frames_per_s || !b_.frames_per_s) return;
    const auto results = [](std::span<const Interval> entries) {
      double sum = 0;
      for (const Interval& entry : entries) sum += entry.results;
      return sum;
    };
    DiffRow row{.name = "throughput", .unit = "frames/s", .a = *a_.frames_per_s, .b = *b_.frames_per_s};
    add_of_timeline(std::move(row), -1, [&](const MeasuredRun& run) {
      // Around the figure that the load test tells.
      const double own = results(run.timeline);
      const double scale = own > 0 ? *run.frames_per_s / own : 0;
      return timeline_replicates(
          run, [&](auto entries) { return scale * results(entries); }, random_);
    });
  }

  /// A percentile with fewer than five frames beyond it, in either load test, is no ground to say that it changed.
  void compare_latency(const char* name, double q) {
    if (a_.frames() == 0 || b_.frames() == 0) return;
    DiffRow row{.name = name, .unit = "ms", .a = a_.quantile(q), .b = b_.quantile(q)};
    if (std::isinf(row.a) && std::isinf(row.b)) return;
    row.method = "histogram";
    auto of_a = quantile_replicates(a_, q, random_), of_b = quantile_replicates(b_, q, random_);
    set_change(row, std::move(of_a), std::move(of_b), options_.confidence);
    add(std::move(row), 1, options_.allow);
    constexpr double kFewest = 5;
    DiffVerdict& verdict = rows_.back().verdict;
    const bool has_few = (1 - q) * std::min(a_.frames(), b_.frames()) < kFewest;
    if (has_few && verdict != DiffVerdict::kSame) verdict = DiffVerdict::kUnclear;
  }

  void compare_errors() {
    const auto share = [](double failed, double all) { return all > 0 ? 100 * failed / all : 0; };
    const auto of_run = [&](const MeasuredRun& run) { return share(run.sent - run.results - run.dropped, run.sent); };
    DiffRow row{.name = "errors", .unit = "% of frames", .a = of_run(a_), .b = of_run(b_), .is_share = true};
    add_of_timeline(std::move(row), 1, [&](const MeasuredRun& run) {
      const auto figure = [&](std::span<const Interval> entries) {
        double failed = 0, all = 0;
        for (const Interval& entry : entries) {
          failed += entry.failed;
          all += entry.failed + entry.results;
        }
        return share(failed, all);
      };
      return timeline_replicates(run, figure, random_);
    });
  }

  void compare_cpu() {
    if (a_.client_cpu_ms && b_.client_cpu_ms) {
      DiffRow row{.name = "CPU of segctl", .unit = "ms a frame", .a = *a_.client_cpu_ms, .b = *b_.client_cpu_ms};
      add_of_timeline(std::move(row), 1, [&](const MeasuredRun& run) {
        if (!std::ranges::all_of(run.timeline, [](const Interval& entry) { return entry.busy_cpus.has_value(); })) {
          return Values{};
        }
        const auto figure = [&](std::span<const Interval> entries) {
          double seconds = 0, results = 0;
          for (const Interval& entry : entries) {
            seconds += *entry.busy_cpus * run.step_s;
            results += entry.results;
          }
          return results > 0 ? 1000 * seconds / results : kInfinity;
        };
        return timeline_replicates(run, figure, random_);
      });
    }
    if (a_.server_cpu_ms && b_.server_cpu_ms) {
      DiffRow row{.name = "CPU of the server", .unit = "ms a frame", .a = *a_.server_cpu_ms, .b = *b_.server_cpu_ms};
      set_change(row, {}, {}, options_.confidence);
      add(std::move(row), 1, options_.allow);
    }
  }

  std::vector<DiffRow> rows() && { return std::move(rows_); }

 private:
  template <typename Replicates>
  void add_of_timeline(DiffRow row, double sign, const Replicates& replicates) {
    row.method = "timeline";
    auto of_a = replicates(a_), of_b = replicates(b_);
    set_change(row, std::move(of_a), std::move(of_b), options_.confidence);
    const double allowed = row.is_share ? options_.allow * row.a : options_.allow;
    add(std::move(row), sign, allowed);
  }

  void add(DiffRow row, double sign, double allowed) {
    row.verdict = judge(row, sign, allowed);
    rows_.push_back(std::move(row));
  }

  const MeasuredRun& a_;
  const MeasuredRun& b_;
  DiffOptions options_;
  Random random_;
  std::vector<DiffRow> rows_;
};

}  // namespace

const char* name(DiffVerdict verdict) {
  switch (verdict) {
    case DiffVerdict::kSame:
      return "same";
    case DiffVerdict::kBetter:
      return "better";
    case DiffVerdict::kWorse:
      return "worse";
    case DiffVerdict::kUnclear:
      return "unclear";
  }
  return "unknown";
}

RunDiff diff_runs(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b, const DiffOptions& options) {
  const MeasuredRun run_a = measured_run(a), run_b = measured_run(b);
  Comparison comparison(run_a, run_b, options);
  comparison.compare_throughput();
  comparison.compare_latency("p50", 0.5);
  comparison.compare_latency("p95", 0.95);
  comparison.compare_latency("p99", 0.99);
  comparison.compare_errors();
  comparison.compare_cpu();
  return {.options = options, .rows = std::move(comparison).rows(), .caveats = caveats(a, b)};
}

}  // namespace segserve::bench_report
