// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/app/flags.hpp"
#include "server/server.hpp"

namespace segserve::server {

/// Writes to the log what the server is that has just begun to serve: where it listens, and its limits.
void announce(const Server& server, const Flags& flags);

/// Writes to the log that the server stops because of this signal.
void announce_stop(const Server& server, int signal);

}  // namespace segserve::server
