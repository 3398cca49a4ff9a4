// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"

namespace segserve::segctl {

/// Waits at `listen`, HOST:PORT, for load tests that want this process to generate a part of their load, one at a time,
/// until Ctrl-C. Says on standard output where it listens. Whoever reaches the address can load any server through it,
/// unless they must prove that they know the `secret`, which is empty if there is none. Without one, an address beyond
/// this machine is refused unless `anyone`. INVALID_ARGUMENT for that and for what is no address; UNAVAILABLE if it
/// cannot be bound.
absl::Status serve_as_agent(const std::string& listen, const std::string& secret, bool anyone);

}  // namespace segserve::segctl
