// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <csignal>

#include "server/log/program_log.hpp"

namespace segserve::server {

/// Blocks the signals that the program waits for, for this thread and every thread that it starts from now on.
sigset_t block_signals();

/// Waits for SIGTERM, SIGINT or SIGQUIT, and returns its number. Until then, SIGUSR1 makes the log one step more
/// talkative, SIGUSR2 one step less, and SIGHUP is told in the log. `signals` are those of block_signals.
int wait_for_stop(const sigset_t& signals, ProgramLog& log);

}  // namespace segserve::server
