// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/load_test/findings.hpp"
#include "client/load_test/load.hpp"
#include "client/load_test/objective.hpp"
#include "client/load_test/plan.hpp"
#include "client/load_test/search.hpp"
#include "client/load_test/server_metrics.hpp"
#include "nlohmann/json.hpp"

namespace segserve::segctl {

/// A load test and its measurements.
struct BenchSummary {
  bench::LoadResult result;
  bench::LoadOptions load;
  std::vector<bench::Objective> objectives;
  std::vector<bench::Finding> findings;
  std::vector<bench::LoadPoint> points;  ///< none if the load has one level
  std::optional<bench::Objective> search;
  std::optional<bench::Capacity> capacity;  ///< that the search found
  std::string server;
  std::vector<std::string> codecs;  ///< in the order of LoadResult::codecs
  std::optional<bench::ServerMetrics> server_metrics;
  std::optional<std::map<std::string, std::uint64_t>> faults;  ///< how often each kind of --fault happened
  std::optional<double> offered;                               ///< open loop: frames a second of all clients together
  double started = 0;                                          ///< seconds since 1970, when the runs began
  nlohmann::ordered_json host, server_info;

  /// The codecs for people, e.g. "planar, rgbd".
  std::string codec() const;
};

/// When the frames of an open loop come: "constant", "poisson" or "recorded".
const char* arrivals_name(const bench::LoadOptions& load);

/// The first reason for an exit code other than 0, or OK: CANCELLED if the run was interrupted.
absl::Status verdict(const BenchSummary& summary);

}  // namespace segserve::segctl
