// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load_test/line_socket.hpp"
#include "client/load_test/plan.hpp"
#include "client/segctl/agent_address.hpp"

namespace segserve::segctl {

/// Agents that generate the load of this process's test, see bench_agent.hpp.
class AgentGroup {
 public:
  /// Connects to all of them, and has them prepare their frames. `arguments` are the words of this process's command
  /// line behind "bench". `secret` is that of the agents, or empty. UNAVAILABLE and what an agent says, with its
  /// address; PERMISSION_DENIED if an agent has another secret, or has one while `secret` is empty.
  static absl::StatusOr<std::shared_ptr<AgentGroup>> connect(const std::vector<AgentAddress>& addresses,
                                                             const std::vector<std::string>& arguments,
                                                             const std::string& secret);

  /// Runs the load once, its clients spread evenly over the agents, and adds up what they measured. The observer hears
  /// of the intervals when all agents are done. Errors as of connect().
  absl::StatusOr<bench::LoadResult> run(const bench::LoadOptions& load, const bench::LoadObserver& observer);

 private:
  struct Agent {
    AgentAddress address;
    bench::LineSocket socket;
  };

  static absl::Status greet(Agent& agent, const std::vector<std::string>& arguments, const std::string& secret);

  std::vector<Agent> agents_;
};

/// Runs loads by agents.
bench::LoadRunner agents_runner(std::shared_ptr<AgentGroup> agents);

}  // namespace segserve::segctl
