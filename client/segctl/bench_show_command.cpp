// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "client/bench_report/run_json.hpp"
#include "client/bench_report/run_text.hpp"
#include "client/segctl/bench_html.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

HelpText help() {
  return {.common = {"--html"},
          .examples = R"(segctl bench show run.json
segctl bench show run.json --html report.html)",
          .details = "The page is one file that needs no network. It also prints well.",
          .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad input or usage."};
}

struct ShowArguments {
  std::string input;
  BenchHtmlFlag html;

  void add_to(CLI::App& app) {
    app.add_option("RUN", input, "what segctl bench --json wrote; - is standard input")->type_name("FILE")->required();
    html.add_to(app);
  }
};

absl::Status run(const ShowArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(output.protect({arguments.input}, true));
  RETURN_IF_ERROR(arguments.html.announce(output));
  ASSIGN_OR_RETURN(const std::string bytes, read_input(arguments.input));
  const auto told = bench_report::parse_run(bytes);
  if (!told.ok()) return with_prefix(input_name(arguments.input), told.status());
  RETURN_IF_ERROR(arguments.html.add(output, *told));
  if (!output.uses_stdout()) output.add("-", bench_report::to_text(*told));
  return output.commit();
}

}  // namespace

void add_bench_show_command(CLI::App& bench, Command& chosen) {
  add_command(bench, chosen, "show", "Show a load test that was saved by --json", help(), run);
}

}  // namespace segserve::segctl
