// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/load_test/load.hpp"
#include "nlohmann/json.hpp"

// The messages between a load test and its agents, as JSON, one object a line. The load test begins:
//
//   {"segserve_bench_agent": 1, "arguments": ["--size", "160x120", ..]}   -> {"ready": true}
//   {"run": {"clients": 4, "rates": [..], ..}}                            -> {"result": {..}}
//   {"stop": true}, which ends a run early and has no answer of its own
//
// In place of an answer, {"error": {"code": 3, "message": ".."}} says what went wrong. The end of the connection ends
// everything.
namespace segserve::segctl {

inline constexpr int kAgentProtocol = 1;

/// Makes the message that starts a run. It holds the options that differ from run to run.
nlohmann::json run_message(const bench::LoadOptions& load);
/// Takes over what such a message says. INVALID_ARGUMENT if it is no such message.
absl::Status apply_run_message(const nlohmann::json& message, bench::LoadOptions& load);

/// The measurements of an agent, and the latencies of each interval of its timeline.
struct AgentResult {
  bench::LoadResult result;
  std::vector<bench::HdrHistogram> intervals;
};

nlohmann::json result_message(const AgentResult& measured);
/// INVALID_ARGUMENT if it is no such message. Latencies come back as those of their buckets.
absl::StatusOr<AgentResult> parse_result_message(const nlohmann::json& message);

nlohmann::json error_message(const absl::Status& status);
/// Returns the error that the message reports; OK if it reports none.
absl::Status parse_error_message(const nlohmann::json& message);

/// The sum of what the agents of one run measured, at least one. Their clients follow each other.
AgentResult merged(const std::vector<AgentResult>& agents);

}  // namespace segserve::segctl
