#pragma once

#include <functional>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"

namespace segserve::segctl {

/// What the parsed command line asks for. The status it returns decides the exit code (exit_code.hpp).
using Command = std::function<absl::Status()>;

/// Each adds one subcommand to `app`; parsing it stores what is to be run in `chosen`.
void add_segment_command(CLI::App& app, Command& chosen);
void add_cut_command(CLI::App& app, Command& chosen);
void add_synth_command(CLI::App& app, Command& chosen);
void add_eval_command(CLI::App& app, Command& chosen);
void add_bench_command(CLI::App& app, Command& chosen);
void add_info_command(CLI::App& app, Command& chosen);
void add_health_command(CLI::App& app, Command& chosen);

}  // namespace segserve::segctl
