// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "client/segctl/help.hpp"

namespace segserve::segctl {

/// The work that the parsed command line asks for. The status that it returns decides the exit code (exit_code.hpp).
using Command = std::function<absl::Status()>;

/// Adds one subcommand to `app`. Parsing it stores in `chosen` the call of `run` with the parsed arguments.
/// `Arguments` has a member add_to(CLI::App&), which adds the options. If it gets subcommands of its own, and one of
/// them is parsed, that one is chosen.
template <typename Arguments>
void add_command(CLI::App& app, Command& chosen, const std::string& name, const std::string& description, HelpText help,
                 absl::Status (*run)(const Arguments&)) {
  CLI::App* command = app.add_subcommand(name, description);
  auto arguments = std::make_shared<Arguments>();  // The options write to it until the command has run.
  arguments->add_to(*command);
  set_help(*command, std::move(help));
  command->callback([command, arguments, run, &chosen] {
    if (command->get_subcommands().empty()) chosen = [arguments, run] { return run(*arguments); };
  });
}

void add_segment_command(CLI::App& app, Command& chosen);
void add_cut_command(CLI::App& app, Command& chosen);
void add_pick_command(CLI::App& app, Command& chosen);
void add_view_command(CLI::App& app, Command& chosen);
void add_stream_command(CLI::App& app, Command& chosen);
void add_synth_command(CLI::App& app, Command& chosen);
void add_eval_command(CLI::App& app, Command& chosen);
void add_bench_command(CLI::App& app, Command& chosen);
/// These add "show" and "diff" to the command "bench".
void add_bench_show_command(CLI::App& bench, Command& chosen);
void add_bench_diff_command(CLI::App& bench, Command& chosen);
void add_info_command(CLI::App& app, Command& chosen);
void add_health_command(CLI::App& app, Command& chosen);
void add_token_command(CLI::App& app, Command& chosen);

}  // namespace segserve::segctl
