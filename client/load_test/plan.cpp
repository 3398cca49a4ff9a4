// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/plan.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <initializer_list>
#include <map>
#include <memory>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::bench {
namespace {

constexpr std::chrono::milliseconds kSearchDrain{2000};  // an overloaded try needs not be waited for
constexpr std::size_t kWindowsThatAgree = 3;

/// Whether a level met the objectives: "met", "missed" or "unstable"; empty without any.
std::string verdict_of(const Report& report, const std::vector<Objective>& objectives, bool is_open) {
  if (is_open && falls_behind(report)) return "unstable";
  if (objectives.empty()) return "";
  const bool may_fail = bounds_errors(objectives) || report.failed() == 0;
  const bool met = may_fail && std::ranges::all_of(objectives, [&](const auto& each) { return is_met(each, report); });
  return met ? "met" : "missed";
}

LoadPoint point_of(std::string label, const LoadOptions& load, const Report& report,
                   const std::vector<Objective>& objectives) {
  LoadPoint point;
  point.label = std::move(label);
  point.clients = load.clients;
  if (load.is_open() && report.seconds > 0) point.offered = static_cast<double>(report.sent) / report.seconds;
  point.report = report;
  point.verdict = verdict_of(report, objectives, load.is_open());
  return point;
}

/// The server's cost of a frame since the last call.
std::optional<double> server_cost(const LoadPlan& plan) {
  return plan.server_cpu_ms_per_frame ? plan.server_cpu_ms_per_frame() : std::nullopt;
}

bool is_interrupted(const LoadOptions& load) { return load.interrupt != nullptr && *load.interrupt; }

/// One run, with a point for each of its levels.
absl::StatusOr<LoadRuns> run_once(const LoadPlan& plan, const std::vector<Objective>& objectives,
                                  const LoadRunner& runner, const LoadObserver& observer) {
  LoadRuns runs;
  std::vector<std::optional<double>> costs;
  LoadObserver watching = observer;
  watching.on_level = [&](const std::vector<Report>& levels) {
    costs.push_back(server_cost(plan));
    return observer.on_level && observer.on_level(levels);
  };
  ASSIGN_OR_RETURN(runs.result, runner(plan.load, watching));
  costs.push_back(server_cost(plan));  // of the last level
  for (std::size_t i = 0; i < std::min(plan.level_labels.size(), runs.result.levels.size()); ++i) {
    LoadPoint& point =
        runs.points.emplace_back(point_of(plan.level_labels[i], plan.load, runs.result.levels[i], objectives));
    if (i < costs.size()) point.server_cpu_ms_per_frame = costs[i];
  }
  return runs;
}

/// The clients of several runs have no common share, so that the total has that of the run where it is lowest.
void tell_least_share(LoadRuns& runs) {
  Report& total = runs.result.total;
  total.finished_of_client.clear();
  for (const LoadPoint& point : runs.points) {
    const double share = point.report.least_share_percent();
    total.least_share_of_runs = std::min(share, total.least_share_of_runs.value_or(share));
  }
}

/// A run for each number of clients.
absl::StatusOr<LoadRuns> run_sweep(const LoadPlan& plan, const std::vector<Objective>& objectives,
                                   const LoadRunner& runner, const LoadObserver& observer) {
  LoadRuns runs;
  LoadOptions load = plan.load;
  for (const std::size_t clients : plan.client_counts) {
    if (is_interrupted(load)) break;
    load.clients = clients;
    ASSIGN_OR_RETURN(LoadResult result, runner(load, observer));
    runs.points.push_back(
        point_of(fmt::format("{} client{}", clients, clients == 1 ? "" : "s"), load, result.total, objectives));
    runs.points.back().server_cpu_ms_per_frame = server_cost(plan);
    if (runs.result.parts.empty()) {
      runs.result = std::move(result);
    } else {
      runs.result.append(result);
    }
  }
  tell_least_share(runs);
  return runs;
}

/// Whether all values are so near to their mean.
bool agree(std::initializer_list<double> values, double share) {
  double sum = 0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(values.size());
  return std::isfinite(mean) && mean > 0 &&
         std::ranges::all_of(values, [&](double value) { return std::abs(value - mean) <= share * mean; });
}

/// Whether throughput and median latency of the last windows agree.
bool is_settled(const std::vector<Report>& windows, double share) {
  static_assert(kWindowsThatAgree == 3);
  if (windows.size() < kWindowsThatAgree) return false;
  const Report& a = windows[windows.size() - 3];
  const Report& b = windows[windows.size() - 2];
  const Report& c = windows[windows.size() - 1];
  return agree({a.frames_per_second(), b.frames_per_second(), c.frames_per_second()}, share) &&
         agree({a.latency.percentile(50), b.latency.percentile(50), c.latency.percentile(50)}, share);
}

/// Windows follow each other until three agree. Those are reported.
absl::StatusOr<LoadRuns> run_until_stable(const LoadPlan& plan, const std::vector<Objective>& objectives,
                                          const LoadRunner& runner, LoadObserver observer) {
  LoadPlan windows = plan;
  windows.load.levels.assign(kMostWindows, plan.load.duration);
  windows.load.duration = kMostWindows * plan.load.duration;
  observer.on_level = [&](const std::vector<Report>& levels) { return is_settled(levels, *plan.until_stable); };
  ASSIGN_OR_RETURN(LoadRuns runs, run_once(windows, objectives, runner, observer));
  auto& parts = runs.result.parts;
  if (!is_settled(runs.result.levels, *plan.until_stable)) {
    runs.findings.push_back(
        {"UNSTABLE",
         fmt::format("Throughput and median latency did not settle: among {} windows of {:g} s no three in a "
                     "row agreed within {:g} %.",
                     runs.result.levels.size(), std::chrono::duration<double>(plan.load.duration).count(),
                     100 * *plan.until_stable)});
  }
  if (parts.size() > kWindowsThatAgree) parts.erase(parts.begin(), parts.end() - kWindowsThatAgree);
  runs.result.summarize();
  return runs;
}

/// The frames per second that a closed loop reaches: a rate to begin a search with.
absl::StatusOr<double> closed_loop_rate(const LoadPlan& plan, const LoadRunner& runner, const LoadObserver& observer) {
  LoadOptions load = plan.load;
  load.rates.clear();
  load.stream.max_waiting = 1;
  load.duration = std::max(std::chrono::milliseconds(1000), load.duration / 4);
  ASSIGN_OR_RETURN(const LoadResult result, runner(load, observer));
  return std::max(1.0, result.total.frames_per_second());
}

absl::StatusOr<LoadRuns> run_search(const LoadPlan& plan, const std::vector<Objective>& objectives,
                                    const LoadRunner& runner, const LoadObserver& observer) {
  LoadRuns runs;
  std::vector<Objective> all = objectives;
  all.push_back(*plan.search);
  LoadOptions load = plan.load;
  load.drain = std::min(load.drain, kSearchDrain);
  SearchOptions options;
  if (plan.search_first) {
    options.first = *plan.search_first;
  } else {
    ASSIGN_OR_RETURN(options.first, closed_loop_rate(plan, runner, observer));
  }
  std::map<double, LoadResult> met_at;  // by rate, the last try
  const auto attempt = [&](double rate) -> absl::StatusOr<bool> {
    load.rates = {{rate, rate, std::chrono::duration<double>(load.duration).count()}};
    ASSIGN_OR_RETURN(LoadResult result, runner(load, observer));
    if (result.interrupted) return absl::CancelledError("interrupted");
    runs.points.push_back(point_of(fmt::format("{:.1f} frames/s", rate), load, result.total, all));
    runs.points.back().server_cpu_ms_per_frame = server_cost(plan);
    const bool met = runs.points.back().verdict == "met";
    if (met) met_at[rate] = result;
    runs.result = std::move(result);
    return met;
  };
  auto capacity = find_capacity(options, attempt);
  if (absl::IsCancelled(capacity.status()) && !runs.points.empty()) {
    runs.result.interrupted = true;
    return runs;
  }
  RETURN_IF_ERROR(capacity.status());
  const auto found = met_at.find(capacity->low);
  if (found != met_at.end()) runs.result = std::move(found->second);
  runs.capacity = *std::move(capacity);
  return runs;
}

}  // namespace

absl::StatusOr<LoadRunner> local_runner(const LoadPlan& plan, FrameSource source) {
  LoadOptions most = plan.load;
  most.clients = std::ranges::max(plan.client_counts);
  ASSIGN_OR_RETURN(auto prepared, prepare_frames(most, source));
  const auto frames = std::make_shared<const PreparedFrames>(std::move(prepared));
  return [frames, source = std::move(source)](const LoadOptions& load, const LoadObserver& observer) {
    const std::size_t used = std::min(load.clients_of_all(), frames->size());
    return run_load(load, source, {frames->begin(), frames->begin() + static_cast<std::ptrdiff_t>(used)}, observer);
  };
}

absl::StatusOr<LoadRuns> run_plan(const LoadPlan& plan, const std::vector<Objective>& objectives,
                                  const LoadRunner& runner, const LoadObserver& observer) {
  if (plan.search) return run_search(plan, objectives, runner, observer);
  if (plan.client_counts.size() > 1) return run_sweep(plan, objectives, runner, observer);
  if (plan.until_stable) return run_until_stable(plan, objectives, runner, observer);
  return run_once(plan, objectives, runner, observer);
}

}  // namespace segserve::bench
