// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace segserve::server {

/// The names of hosts in a list such as "robot.example,10.0.0.7", in small letters; an IPv6 address stands in brackets.
/// INVALID_ARGUMENT for a text that no header Host has.
absl::StatusOr<std::vector<std::string>> parse_host_names(std::string_view list);

/// Whether a header Host, with or without a port, names this machine (localhost, 127.0.0.0/8, [::1]) or one of these
/// hosts, which parse_host_names gave. A page whose site gives its own name the address 127.0.0.1 (DNS rebinding) sends
/// the name of its site.
bool is_host_allowed(std::string_view host, const std::vector<std::string>& names);

}  // namespace segserve::server
