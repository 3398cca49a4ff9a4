// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <exception>
#include <string>

#include "CLI/CLI.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/exit_code.hpp"
#include "client/segctl/messages.hpp"
#include "command_line/usage_faults.hpp"
#include "core/base/status_text.hpp"
#include "grpc/support/log.h"
#include "segserve/wire/error_details.hpp"

namespace {

using namespace segserve::segctl;  // NOLINT(google-build-using-namespace): this file is their main

constexpr const char* kFooter =
    R"("segctl COMMAND --help" shows a command's most useful options and examples, "segctl COMMAND --help-all" all of them.
Errors are one line on standard error.

Exit codes: 0 success; 1 the operation failed (server unreachable or not serving, deadline exceeded, disk full);
2 bad input or usage.)";

/// gRPC writes lines of its own about failed handshakes. Those who want them set its usual variable.
void silence_grpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args* /*line*/) {});
}

/// Advises what to do about an error that a server has told, as a part of the message.
std::string advice(const absl::Status& status) {
  const bool needs_token = segserve::wire::details_of(status).reason == segserve::wire::ErrorReason::kTokenMissing;
  return needs_token ? "; --token-file names the file that holds one" : "";
}

int run(int argc, char** argv) {
  CLI::App app("Segment colored 3D point clouds, through a segserve server or in this process.", "segctl");
  Command chosen;
  app.require_subcommand(1);
  app.set_version_flag("--version", "segctl " SEGSERVE_VERSION);
  app.footer(kFooter);
  add_segment_command(app, chosen);
  add_cut_command(app, chosen);
  add_pick_command(app, chosen);
  add_view_command(app, chosen);
  add_stream_command(app, chosen);
  add_synth_command(app, chosen);
  add_eval_command(app, chosen);
  add_bench_command(app, chosen);
  add_bench_show_command(*app.get_subcommand("bench"), chosen);
  add_bench_diff_command(*app.get_subcommand("bench"), chosen);
  add_info_command(app, chosen);
  add_health_command(app, chosen);
  add_token_command(app, chosen);
  app.set_help_all_flag("--help-all", "Show every option of every command");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --help-all or --version
    print_error(segserve::usage_faults(app, error));
    return kBadInput;
  }
  // The health service without a name is the server as a whole.
  const std::string empty = segserve::empty_values(app, {"--service"});
  if (!empty.empty()) {
    print_error(empty);
    return kBadInput;
  }
  const absl::Status status = chosen();
  if (!status.ok()) print_error(segserve::message_of(status) + advice(status));
  return exit_code(status);
}

}  // namespace

int main(int argc, char** argv) {
  silence_grpc();
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {  // In practice this is std::bad_alloc.
    print_error(error.what());
    return kFailed;
  }
}
