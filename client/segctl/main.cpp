#include <exception>
#include <string>

#include "CLI/CLI.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/exit_code.hpp"
#include "fmt/format.h"

namespace {

using namespace segserve::segctl;  // NOLINT(google-build-using-namespace): this file is their main

constexpr const char* kFooter =
    R"("segctl COMMAND --help" tells more, with examples. Errors are one line on standard error.

Exit codes: 0 done; 1 failed (server unreachable or not serving, time over, disk full);
2 bad input or usage.)";

int run(int argc, char** argv) {
  CLI::App app("Segment coloured 3D point clouds, by a segserve server or in this process.", "segctl");
  Command chosen;
  app.require_subcommand(1);
  app.set_version_flag("--version", "segctl " SEGSERVE_VERSION);
  app.footer(kFooter);
  add_segment_command(app, chosen);
  add_cut_command(app, chosen);
  add_synth_command(app, chosen);
  add_eval_command(app, chosen);
  add_bench_command(app, chosen);
  add_info_command(app, chosen);
  add_health_command(app, chosen);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help or --version
    print_error(fmt::format("{} (see segctl --help)", error.what()));
    return kBadInput;
  }
  const absl::Status status = chosen();
  if (!status.ok()) print_error(std::string_view(status.message().data(), status.message().size()));
  return exit_code(status);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {  // std::bad_alloc, above all
    print_error(error.what());
    return kFailed;
  }
}
