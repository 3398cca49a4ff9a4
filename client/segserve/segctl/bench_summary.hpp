#pragma once

#include <string>
#include <vector>

#include "nlohmann/json_fwd.hpp"
#include "segserve/bench/load.hpp"
#include "segserve/bench/objective.hpp"
#include "segserve/bench/report.hpp"

namespace segserve::segctl {

/// A load test and what it measured.
struct BenchSummary {
  const bench::Report& report;
  const bench::LoadOptions& load;
  const std::vector<bench::Objective>& objectives;
  std::string server, codec;
};

nlohmann::ordered_json to_json(const BenchSummary& summary);

/// A table for people.
std::string to_text(const BenchSummary& summary);

}  // namespace segserve::segctl
