// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "client/fleet/server_directory.hpp"
#include "client/fleet/server_name.hpp"

namespace segserve::client {

/// Finds the addresses of a host, in the order in which they should be tried. May block for long.
using HostLookup = std::function<absl::StatusOr<std::vector<HostAddress>>(const HostName&)>;

/// Asks the system as every program does: /etc/hosts, DNS, and whatever else it is configured for. UNAVAILABLE with the
/// system's reason if it finds nothing.
absl::StatusOr<std::vector<HostAddress>> look_up_host(const HostName& name);

}  // namespace segserve::client
