// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::segctl {

/// Where an agent of a load test listens.
struct AgentAddress {
  std::string host, port;

  /// True if only this machine can reach it: "localhost", 127.0.0.0/8 or ::1.
  bool is_loopback() const;
  std::string text() const;
};

/// "HOST:PORT" or "[IPv6]:PORT"; INVALID_ARGUMENT, with the flag, if it is neither.
absl::StatusOr<AgentAddress> parse_agent_address(std::string_view flag, std::string_view text);
/// Several, separated by commas.
absl::StatusOr<std::vector<AgentAddress>> parse_agent_addresses(std::string_view flag, std::string_view text);

}  // namespace segserve::segctl
