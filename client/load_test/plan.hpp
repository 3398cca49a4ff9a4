// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/findings.hpp"
#include "client/load_test/load.hpp"
#include "client/load_test/objective.hpp"
#include "client/load_test/search.hpp"

namespace segserve::bench {

/// One level of a load that has several: a step, a part of a ramp, a number of clients, or a try of a search.
struct LoadPoint {
  std::string label;  ///< e.g. "20 frames/s"
  std::size_t clients = 0;
  std::optional<double> offered;  ///< open loop: frames a second of all clients together
  Report report;
  std::optional<double> server_cpu_ms_per_frame;
  std::string verdict;  ///< "met", "missed", "unstable"; empty: nothing was asked
};

/// The runs that a user asks for.
struct LoadPlan {
  LoadOptions load;                        ///< of one run
  std::vector<std::string> level_labels;   ///< of load.levels; empty: they are not reported
  std::vector<std::size_t> client_counts;  ///< several: a run for each
  std::optional<Objective> search;         ///< the highest rate that meets it is searched
  std::optional<double> search_first;      ///< the rate that is tried first; unset: what a closed loop reaches
  std::optional<double> until_stable;      ///< windows of load.duration follow each other until three agree so well
  /// Tells what a frame has cost the server, ms of one CPU, since the last call; may be empty.
  std::function<std::optional<double>()> server_cpu_ms_per_frame = nullptr;
};

/// The most windows of LoadPlan::until_stable.
inline constexpr std::size_t kMostWindows = 10;

/// The measurements of all runs.
struct LoadRuns {
  LoadResult result;  ///< of all runs; of a search, that with the highest rate that met it, or else the last one
  std::vector<LoadPoint> points;
  std::optional<Capacity> capacity;  ///< of a search
  std::vector<Finding> findings;     ///< that are about several runs
};

/// Runs a load once, as run_load() does.
using LoadRunner = std::function<absl::StatusOr<LoadResult>(const LoadOptions&, const LoadObserver&)>;

/// Runs loads of the plan in this process. Fails for a cloud that cannot be encoded.
absl::StatusOr<LoadRunner> local_runner(const LoadPlan& plan, FrameSource source);

/// Runs the plan. `observer` hears of each run. After an interruption, what was measured until then is returned.
absl::StatusOr<LoadRuns> run_plan(const LoadPlan& plan, const std::vector<Objective>& objectives,
                                  const LoadRunner& runner, const LoadObserver& observer);

}  // namespace segserve::bench
