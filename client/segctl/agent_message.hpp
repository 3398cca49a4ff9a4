// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/load_test/load.hpp"
#include "nlohmann/json.hpp"

// The messages between a load test and its agents, as JSON, one object a line. The agent begins:
//
//   {"segserve_bench_agent": 2, "challenge": "..", "asks_for_proof": true}
//
// Then the load test asks, and the agent answers. `proof` is there if it was asked for; see proof_of_arguments.
//
//   {"segserve_bench_agent": 2, "arguments": ["--size", ..], "proof": ".."}   -> {"ready": true}
//   {"run": {"clients": 4, "rates": [..], ..}}                                -> {"result": {..}}
//   {"stop": true}, which ends a run early and has no answer of its own
//
// In place of an answer, {"error": {"code": 3, "message": ".."}} says what went wrong. The end of the connection ends
// everything.
namespace segserve::segctl {

inline constexpr int kAgentProtocol = 2;

/// The first message of an agent on a connection.
struct AgentGreeting {
  std::string challenge;  ///< random, and used once
  bool asks_for_proof = false;
};

nlohmann::json greeting_message(const AgentGreeting& greeting);
/// INVALID_ARGUMENT if it is no such message, or one of another version.
absl::StatusOr<AgentGreeting> parse_greeting_message(const nlohmann::json& message);

/// By this a load test shows that it knows the secret of an agent: an HMAC of challenge and arguments. The secret
/// itself is never sent, and what was overheard is of no use for another connection.
std::string proof_of_arguments(std::string_view secret, const AgentGreeting& greeting, const nlohmann::json& arguments);
bool is_proof_of_arguments(std::string_view proof, std::string_view secret, const AgentGreeting& greeting,
                           const nlohmann::json& arguments);

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
