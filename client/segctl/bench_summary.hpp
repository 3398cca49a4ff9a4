// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "client/load_test/load.hpp"
#include "client/load_test/load_report.hpp"
#include "client/load_test/objective.hpp"
#include "nlohmann/json_fwd.hpp"

namespace segserve::segctl {

/// A load test and its measurements.
struct BenchSummary {
  const bench::Report& report;
  const bench::LoadOptions& load;
  const std::vector<bench::Objective>& objectives;
  std::string server, codec;
  double offered = 0;  ///< open loop: frames a second of all clients together
};

/// One object. Figures that are computed from results are null if there is no result.
nlohmann::ordered_json to_json(const BenchSummary& summary);

/// A few lines for people.
std::string to_text(const BenchSummary& summary);

}  // namespace segserve::segctl
