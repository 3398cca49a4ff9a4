// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/agent_address.hpp"

#include <algorithm>
#include <string>

#include "core/base/loopback_host.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {

bool AgentAddress::is_loopback() const { return is_loopback_host(host); }

std::string AgentAddress::text() const { return fmt::format("{}:{}", host, port); }

absl::StatusOr<AgentAddress> parse_agent_address(std::string_view flag, std::string_view text) {
  const std::size_t colon = text.rfind(':');
  std::string_view host = text.substr(0, std::min(colon, text.size()));
  const std::string_view port = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const bool is_port =
      !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string_view::npos;
  if (host.empty() || !is_port || std::stoi(std::string(port)) > 65535) {
    return absl::InvalidArgumentError(fmt::format("{} {}: it must be HOST:PORT, with a port up to 65535", flag, text));
  }
  return AgentAddress{std::string(host), std::string(port)};
}

absl::StatusOr<std::vector<AgentAddress>> parse_agent_addresses(std::string_view flag, std::string_view text) {
  std::vector<AgentAddress> addresses;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    ASSIGN_OR_RETURN(addresses.emplace_back(), parse_agent_address(flag, text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return addresses;
}

}  // namespace segserve::segctl
