#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/command.hpp"
#include "client/segctl/degradation_flags.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/lab/eval/evaluation.hpp"
#include "core/lab/eval/report.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr const char* kFooter = R"(Examples:
  segctl eval --data osd/test --json default.json
  segctl eval --data osd/test --method lambda-convex --learn osd/learn
  segctl eval --data osd/test --noise-mm 5 --no-color
  segctl eval --compare default.json lambda.json
  segctl synth --fused --seed 1 -o rooms/1.pcd; segctl eval --data rooms --threshold 0.15

Scenes are the .pcd and .ply files of the folder, with ground truth in the field "label": 0 is not
scored, 1 to 9 are parts of the support (table, floor, walls), 10 and up are objects. Scores are
means over the scenes, by two protocols (core/lab/eval/README.md defines them): one_to_one, as
the paper's Table 1, and the paper's formulas, for all regions and for the objects. ms is the
segmentation alone, on one thread. --learn takes the t of 0, 0.01, .. 1 with the highest mean
one_to_one tp on the scenes of its folder, which are not degraded.

Exit codes: 0 done; 1 failed (disk full); 2 bad input or usage.)";

struct Arguments {
  std::string data;
  std::string learn;
  bool curve = false;
  OptionFlags options;
  DegradationFlags degradation;
  std::vector<std::string> compare;
  std::string json_path;
  bool quiet = false;
};

void add_flags(CLI::App& app, Arguments& arguments) {
  CLI::Option* data = app.add_option("--data", arguments.data, "folder of scenes with ground truth")->type_name("DIR");
  CLI::Option* learn = app.add_option("--learn", arguments.learn, "learn the threshold on the scenes of this folder")
                           ->type_name("DIR")
                           ->needs(data);
  app.add_flag("--curve", arguments.curve, "list the tp of every threshold in the JSON")->needs(learn);
  app.add_option("--compare", arguments.compare, "compare two results of --json, scene by scene")
      ->type_name("A.json B.json")
      ->expected(2)
      ->excludes(data);
  arguments.options.add_to(app);
  arguments.degradation.add_to(app);
  app.add_option("--json", arguments.json_path, "write the result as one JSON object; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("-q,--quiet", arguments.quiet, "print no table")->group("Output");
}

/// Writes JSON and text as asked for.
absl::Status write(const Arguments& arguments, const std::string& json, const std::string& text, StagedOutput& output) {
  if (!arguments.json_path.empty()) output.add(arguments.json_path, json);
  if (!arguments.quiet && !output.uses_stdout()) output.add("-", text);
  return output.commit();
}

absl::StatusOr<eval::Report> load_report(const std::string& path) {
  const auto bytes = read_input(path);
  if (!bytes.ok()) return bytes.status();
  auto report = eval::report_from_json(*bytes);
  if (report.ok()) return report;
  return absl::InvalidArgumentError(fmt::format("{}: {}", input_name(path), std::string(report.status().message())));
}

absl::Status run_comparison(const Arguments& arguments, StagedOutput& output) {
  const auto a = load_report(arguments.compare[0]);
  if (!a.ok()) return a.status();
  const auto b = load_report(arguments.compare[1]);
  if (!b.ok()) return b.status();
  const auto differences = eval::compare(a->per_scene, b->per_scene);
  if (!differences.ok()) return differences.status();
  const std::string name_a = fmt::format("{} ({})", input_name(arguments.compare[0]), a->method);
  const std::string name_b = fmt::format("{} ({})", input_name(arguments.compare[1]), b->method);
  return write(arguments, eval::to_json(*differences, name_a, name_b), eval::to_text(*differences, name_a, name_b),
               output);
}

absl::StatusOr<Options> check_options(const Arguments& arguments) {
  auto options = arguments.options.options();
  if (!options.ok()) return options.status();
  if (options->threads != 1) {
    return absl::InvalidArgumentError(fmt::format("threads: {}: times are those of one thread", options->threads));
  }
  if (!arguments.learn.empty() && (options->threshold || options->regions)) {
    return absl::InvalidArgumentError("--learn excludes --threshold and --regions");
  }
  return options;
}

absl::StatusOr<eval::Learnt> learn(const Arguments& arguments, const Options& options) {
  const auto files = eval::scene_files(arguments.learn);
  if (!files.ok()) return files.status();
  const ProgressBar bar("learning");
  auto sweep = eval::learn_threshold(*files, options, [&](auto done, auto all) { bar.show(done, all); });
  if (!sweep.ok()) return sweep.status();
  return eval::Learnt{arguments.learn, *std::move(sweep), arguments.curve};
}

absl::StatusOr<std::vector<eval::SceneScores>> score(const std::vector<std::filesystem::path>& files,
                                                     const eval::Degradation& degradation, const Options& options) {
  const ProgressBar bar("scoring");
  return eval::evaluate(files, degradation, eval::with_options(options),
                        [&](auto done, auto all) { bar.show(done, all); });
}

absl::Status run_evaluation(const Arguments& arguments, StagedOutput& output) {
  auto options = check_options(arguments);
  if (!options.ok()) return options.status();
  eval::Report report;
  report.method = std::string(name(options->method));
  report.folder = arguments.data;
  report.degradation = arguments.degradation.degradation();
  if (absl::Status status = eval::check(report.degradation); !status.ok()) return status;
  const auto files = eval::scene_files(arguments.data);
  if (!files.ok()) return files.status();

  if (!arguments.learn.empty()) {
    auto learnt = learn(arguments, *options);
    if (!learnt.ok()) return learnt.status();
    options->threshold = eval::ThresholdSweep::threshold(learnt->sweep.best());
    report.learnt = *std::move(learnt);
  }
  if (!options->regions) report.threshold = options->threshold.value_or(default_threshold(options->method));
  auto rows = score(*files, report.degradation, *options);
  if (!rows.ok()) return rows.status();
  report.per_scene = *std::move(rows);
  return write(arguments, eval::to_json(report), eval::to_text(report), output);
}

absl::Status run(const Arguments& arguments) {
  StagedOutput output;
  if (!arguments.json_path.empty()) {
    if (absl::Status status = output.announce(arguments.json_path); !status.ok()) return status;
  }
  if (!arguments.compare.empty()) return run_comparison(arguments, output);
  if (!arguments.data.empty()) return run_evaluation(arguments, output);
  return absl::InvalidArgumentError("--data or --compare is needed: what shall be scored?");
}

}  // namespace

void add_eval_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("eval", "Score a method on scenes with ground truth, or compare two results");
  auto arguments = std::make_shared<Arguments>();
  add_flags(*command, *arguments);
  command->footer(kFooter);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
