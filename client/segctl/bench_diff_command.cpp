// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "absl/strings/str_join.h"
#include "client/bench_report/comparable.hpp"
#include "client/bench_report/run_diff.hpp"
#include "client/bench_report/run_json.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/staged_output.hpp"
#include "command_line/not_negative.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

constexpr const char* kDetails =
    R"(Both are what segctl bench --json wrote. They must have the same schedule, clients, codecs, frames and options of the
method. Where to, and how long was measured may differ.

A figure is worse if it is worse by more than --allow, and if the interval of the change excludes no change at all. It
is unclear if the interval reaches beyond what is allowed. The intervals come from a bootstrap with a fixed seed: those
of throughput, errors and the CPU of segctl from blocks of the timeline, so that seconds that are neighbors stay
together; those of percentiles from the histogram, with as many frames as the timeline shows to be independent. How much
one run differs from the next one for reasons that neither of them saw, such as other load of the machine, no file can
tell: that is what --allow is for.)";

HelpText help() {
  return {.common = {"--allow", "--json"},
          .examples = R"(segctl bench diff before.json after.json
segctl bench diff before.json after.json --allow 5% --json -)",
          .details = kDetails,
          .exit_codes =
              "0 no figure is worse; 1 a figure is worse, or the operation failed (disk full); 2 the load tests\n"
              "cannot be compared, and why, or bad input or usage."};
}

struct DiffArguments {
  std::string first, second;
  std::string allow = "10%";
  std::string confidence = "99%";
  std::uint64_t seed = 1;
  JsonFlag json;

  void add_to(CLI::App& app) {
    app.add_option("FIRST", first, "the load test to compare with")->type_name("FILE")->required();
    app.add_option("SECOND", second, "the load test that is judged")->type_name("FILE")->required();
    app.add_option("--allow", allow, "how much worse a figure may be")
        ->type_name("PERCENT")
        ->capture_default_str()
        ->group("Comparison");
    app.add_option("--confidence", confidence, "of the intervals of the changes")
        ->type_name("PERCENT")
        ->capture_default_str()
        ->group("Comparison");
    app.add_option("--seed", seed, "seed of the bootstrap")
        ->check(not_negative())
        ->capture_default_str()
        ->group("Comparison");
    json.add_to(app, "write the comparison as one JSON object");
  }
};

/// The share that "10%" or "10" means, between limits in percent.
absl::StatusOr<double> parse_percent(const char* flag, const std::string& text, double least, double most) {
  double percent = 0;
  const std::string digits = text.ends_with('%') ? text.substr(0, text.size() - 1) : text;
  const bool is_number = CLI::detail::lexical_cast(digits, percent);
  if (!is_number || !(percent >= least && percent <= most)) {
    return absl::InvalidArgumentError(
        fmt::format("{}: '{}' is no percentage from {:g}% to {:g}%", flag, text, least, most));
  }
  return percent / 100;
}

absl::StatusOr<nlohmann::ordered_json> read_run(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  auto run = bench_report::parse_run(bytes);
  if (!run.ok()) return with_prefix(input_name(path), run.status());
  return run;
}

absl::Status run(const DiffArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(output.protect({arguments.first, arguments.second}, true));
  RETURN_IF_ERROR(arguments.json.announce(output));
  bench_report::DiffOptions options{.seed = arguments.seed};
  ASSIGN_OR_RETURN(options.allow, parse_percent("--allow", arguments.allow, 0, 1000));
  ASSIGN_OR_RETURN(options.confidence, parse_percent("--confidence", arguments.confidence, 50, 99.9));
  ASSIGN_OR_RETURN(const auto first, read_run(arguments.first));
  ASSIGN_OR_RETURN(const auto second, read_run(arguments.second));
  const std::vector<std::string> reasons = bench_report::reasons_not_to_compare(first, second);
  if (!reasons.empty()) {
    return absl::InvalidArgumentError("the load tests cannot be compared: " + absl::StrJoin(reasons, "; "));
  }
  const bench_report::RunDiff diff = bench_report::diff_runs(first, second, options);
  arguments.json.add(output, to_json(diff));
  if (!output.uses_stdout()) output.add("-", to_text(diff));
  RETURN_IF_ERROR(output.commit());
  const std::string worse = worse_figures(diff);
  if (worse.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(fmt::format("worse: {} ({:g} % is allowed)", worse, 100 * options.allow));
}

}  // namespace

void add_bench_diff_command(CLI::App& bench, Command& chosen) {
  add_command(bench, chosen, "diff", "Compare two load tests that were saved by --json, and judge the second one",
              help(), run);
}

}  // namespace segserve::segctl
