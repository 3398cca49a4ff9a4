// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/command.hpp"
#include "client/segctl/degradation_flags.hpp"
#include "client/segctl/eval_tracks.hpp"
#include "client/segctl/exit_code.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/page_flags.hpp"
#include "client/segctl/peer_method.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/track_flags.hpp"
#include "client/segctl/view_flag.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/lab/eval/evaluation.hpp"
#include "core/lab/eval/report.hpp"
#include "core/lab/eval/thumbnails.hpp"
#include "fmt/format.h"
#include "proto/text/view_text.hpp"
#include "segserve/codec/read_options.hpp"

namespace segserve::segctl {
namespace {

constexpr const char* kDetails =
    R"(Scenes are the clouds of the folder (PCD, PLY, LAS, text, NPY, NPZ; also .gz, .zst), with ground truth in the field
"label" ("segment" in LAS): 0 is not scored, 1 to 9 are parts of the support (table, floor, walls), 10 and above are
objects. Scores are means over the scenes: one_to_one, as in the paper's Table 1; the paper's formulas; instances,
panoptic quality, overlap and boundaries as other papers have them. core/lab/eval/README.md defines them. ms is the time
of the segmentation alone, on one thread. --view holds for the scenes of --learn, too.

--peer lccp scores PCL's VCCS and LCCP on the same scenes, with the settings of that README, and adds a paired t-test of
each score. Its voxels suit a table at 1 m; name others for sparse scenes. It needs a segctl that was built with PCL.

--track scores sequences instead: HOTA, its parts DetA and AssA, IDF1, and how often objects change their ids, by the
points of objects and tracks with 100 points or more. Each sequence is segmented in this process, frame by frame.

--learn takes the threshold among 0, 0.01, 0.02 and so on up to 1 that has the highest mean one_to_one tp on the scenes
of its folder. These scenes are not degraded, and all of them must be readable.

A scene of --data that cannot be scored stops no other. Such scenes are listed at the end, one a line, and in "failed"
of the JSON. The exit code is then 2 if each of them is bad input, else 1.)";

HelpText help() {
  return {.common = {"--data", "--compare", "--learn", "--view", "--method", "--threshold", "--noise-mm", "--no-color",
                     "--peer", "--json", "--markdown", "--html"},
          .examples = R"(segctl eval --data osd/test --json default.json
segctl eval --data osd/test --method lambda-convex --learn osd/learn
segctl eval --data osd/test --noise-mm 5 --no-color
segctl eval --data osd/test --peer lccp --html scores.html
segctl eval --compare default.json lambda.json
segctl synth --moving moving; segctl eval --data moving --track
segctl synth --fused --seed 1 -o rooms/1.pcd; segctl eval --data rooms --threshold 0.15)",
          .details = kDetails,
          .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad input or usage."};
}

struct EvalArguments {
  std::string data;
  std::string learn;
  std::string view;
  bool curve = false;
  OptionFlags options;
  DegradationFlags degradation;
  std::vector<std::string> compare;
  std::string peer;
  JsonFlag json;
  PageFlags pages;
  TrackFlags track;
  bool quiet = false;

  void add_to(CLI::App& app);
};

void EvalArguments::add_to(CLI::App& app) {
  CLI::Option* data_flag =
      app.add_option("--data", data, "folder of scenes with ground truth")->type_name("DIR")->group("Scenes");
  CLI::Option* learn_flag = app.add_option("--learn", learn, "learn the threshold on the scenes of this folder")
                                ->type_name("DIR")
                                ->needs(data_flag)
                                ->group("Scenes");
  app.add_option("--view", view,
                 "where the sensor of all scenes is: camera, world, or world:X,Y,Z with its position in meters; "
                 "default: what each file says, or its points make plain")
      ->type_name("VIEW")
      ->needs(data_flag)
      ->group("Scenes");
  app.add_flag("--curve", curve, "list the tp of every threshold in the JSON")->needs(learn_flag)->group("Scenes");
  app.add_option("--compare", compare, "compare two results of --json, scene by scene")
      ->type_name("A.json B.json")
      ->expected(2)
      ->excludes(data_flag)
      ->group("Scenes");
  app.add_option(
         "--peer", peer,
         "score this method of others, too, and compare: lccp (PCL's VCCS and LCCP), or lccp:V,S with the sizes of "
         "its voxels and seeds in meters; default 0.0075,0.03")
      ->type_name("NAME")
      ->needs(data_flag)
      ->group("Scenes");
  track.add_to(app,
               "score how objects keep their ids: --data is a sequence (segctl synth --moving), or a folder of such");
  options.add_to(app);
  degradation.add_to(app);
  json.add_to(app, "write the result as one JSON object");
  pages.add_to(app, data_flag);
  app.add_flag("-q,--quiet", quiet, "print no table")->group("Output");
}

/// Writes JSON and text as the flags ask for them.
absl::Status write(const EvalArguments& arguments, const std::string& json, const std::string& text,
                   StagedOutput& output) {
  arguments.json.add(output, json);
  if (!arguments.quiet && !output.uses_stdout()) output.add("-", text);
  return output.commit();
}

absl::StatusOr<eval::Report> load_report(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  auto report = eval::report_from_json(bytes);
  if (report.ok()) return report;
  return absl::InvalidArgumentError(fmt::format("{}: {}", input_name(path), message_of(report.status())));
}

absl::Status run_comparison(const EvalArguments& arguments, StagedOutput& output) {
  ASSIGN_OR_RETURN(const eval::Report a, load_report(arguments.compare[0]));
  ASSIGN_OR_RETURN(const eval::Report b, load_report(arguments.compare[1]));
  ASSIGN_OR_RETURN(const auto differences, eval::compare(a.per_scene, b.per_scene));
  const std::string name_a = fmt::format("{} ({})", input_name(arguments.compare[0]), a.method);
  const std::string name_b = fmt::format("{} ({})", input_name(arguments.compare[1]), b.method);
  return write(arguments, eval::to_json(differences, name_a, name_b), eval::to_text(differences, name_a, name_b),
               output);
}

absl::StatusOr<Options> check_options(const EvalArguments& arguments) {
  ASSIGN_OR_RETURN(const Options options, arguments.options.options());
  if (options.threads != 1) {
    return absl::InvalidArgumentError(fmt::format("threads: {}: times are those of one thread", options.threads));
  }
  if (!arguments.learn.empty() && (options.threshold || options.regions)) {
    return absl::InvalidArgumentError("--learn excludes --threshold and --regions");
  }
  return options;
}

/// The readers take the view from the command line if it is given there.
absl::StatusOr<codec::ReadOptions> read_options(const EvalArguments& arguments) {
  codec::ReadOptions read;
  if (!arguments.view.empty()) {
    ASSIGN_OR_RETURN(read.view, parse_view(arguments.view));
  }
  return read;
}

absl::StatusOr<eval::LearnedThreshold> learn(const EvalArguments& arguments, const Options& options,
                                             const codec::ReadOptions& read) {
  ASSIGN_OR_RETURN(const auto files, eval::scene_files(arguments.learn));
  const ProgressBar bar("learning");
  ASSIGN_OR_RETURN(const auto sweep, eval::learn_threshold(
                                         files, options, [&](auto done, auto all) { bar.show(done, all); }, read));
  return eval::LearnedThreshold{arguments.learn, sweep, arguments.curve};
}

/// The scenes that are scored, and how they are read.
struct Scenes {
  std::vector<std::filesystem::path> files;
  codec::ReadOptions read;
};

/// Adds the scores and the failures of a method to its report.
void score(const Scenes& scenes, const eval::SegmentScene& segment, const char* what, eval::Report& report) {
  const ProgressBar bar(what);
  eval::Evaluation evaluation = eval::evaluate(
      scenes.files, report.degradation, segment, [&](auto done, auto all) { bar.show(done, all); }, scenes.read);
  report.per_scene = std::move(evaluation.scores);
  report.failed = std::move(evaluation.failures);
}

eval::Peer score_peer(const Scenes& scenes, const PeerMethod& method, const eval::Report& report) {
  eval::Report peer{.method = method.name,
                    .threshold = {},
                    .folder = report.folder,
                    .view = report.view,
                    .degradation = report.degradation,
                    .learned = {},
                    .per_scene = {}};
  score(scenes, method.segment, "scoring the peer", peer);
  return eval::compare_with(report, std::move(peer));
}

/// Pictures of the worst scenes. Each of them was read and segmented before.
absl::StatusOr<std::vector<eval::Thumbnails>> draw_worst(const Scenes& scenes, const eval::SegmentScene& segment,
                                                         const eval::Report& report, std::size_t count) {
  std::vector<eval::Thumbnails> pictures;
  for (const std::string& file : eval::worst_scenes(report.per_scene, count)) {
    ASSIGN_OR_RETURN(auto pair, eval::make_thumbnails(std::filesystem::path(report.folder) / file, report.degradation,
                                                      segment, scenes.read));
    pictures.push_back(std::move(pair));
  }
  return pictures;
}

/// Lists the scenes that failed, those of a peer behind ours. INVALID_ARGUMENT if each of them is bad input.
absl::Status report_failures(const eval::Report& report, const eval::Peer* peer) {
  const auto is_ours = [&](const eval::SceneFailure& scene) {
    return std::ranges::find(report.failed, scene.file, &eval::SceneFailure::file) != report.failed.end();
  };
  std::vector<eval::SceneFailure> failed = report.failed;
  if (peer != nullptr) {  // a file that both cannot read is told once
    std::ranges::copy_if(peer->report.failed, std::back_inserter(failed), std::not_fn(is_ours));
  }
  if (failed.empty()) return absl::OkStatus();
  if (report.per_scene.empty() && failed.size() == 1) return failed.front().status;
  for (const eval::SceneFailure& scene : failed) print_error(message_of(scene.status));
  const auto is_bad_input = [](const auto& scene) { return exit_code(scene.status) == kBadInput; };
  const auto code =
      std::ranges::all_of(failed, is_bad_input) ? absl::StatusCode::kInvalidArgument : absl::StatusCode::kUnavailable;
  return {code, fmt::format("{} of {} scenes failed", failed.size(), failed.size() + report.per_scene.size())};
}

absl::Status run_evaluation(const EvalArguments& arguments, StagedOutput& output) {
  ASSIGN_OR_RETURN(Options options, check_options(arguments));
  eval::Report report;
  report.method = std::string(name(options.method));
  report.folder = arguments.data;
  report.degradation = arguments.degradation.degradation();
  RETURN_IF_ERROR(eval::check(report.degradation));
  Scenes scenes;
  ASSIGN_OR_RETURN(scenes.read, read_options(arguments));
  if (scenes.read.view) report.view = text::view_text(*scenes.read.view);
  std::optional<PeerMethod> peer_to_score;
  if (!arguments.peer.empty()) {
    ASSIGN_OR_RETURN(peer_to_score, peer_method(arguments.peer));
  }
  ASSIGN_OR_RETURN(scenes.files, eval::scene_files(arguments.data));
  for (const auto& file : scenes.files) RETURN_IF_ERROR(output.protect({file.string()}, true));

  if (!arguments.learn.empty()) {
    ASSIGN_OR_RETURN(report.learned, learn(arguments, options, scenes.read));
    options.threshold = eval::ThresholdSweep::threshold(report.learned->sweep.best());
  }
  if (!options.regions) report.threshold = options.threshold.value_or(default_threshold(options.method));
  const eval::SegmentScene segment = eval::with_options(options);
  score(scenes, segment, "scoring", report);
  std::optional<eval::Peer> scored_peer;
  if (peer_to_score && !report.per_scene.empty()) scored_peer = score_peer(scenes, *peer_to_score, report);
  const eval::Peer* const peer = scored_peer ? &*scored_peer : nullptr;
  if (!report.per_scene.empty()) {
    ASSIGN_OR_RETURN(const auto worst, draw_worst(scenes, segment, report, arguments.pages.worst()));
    arguments.pages.add(output, report, peer, worst);
    RETURN_IF_ERROR(write(arguments, eval::to_json(report, peer), eval::to_text(report, peer), output));
  }
  return report_failures(report, peer);
}

absl::Status run_tracks(const EvalArguments& arguments, StagedOutput& output) {
  if (arguments.data.empty() || !arguments.learn.empty() || !arguments.peer.empty()) {
    return absl::InvalidArgumentError("--track needs --data, and excludes --learn and --peer");
  }
  TrackEvaluation evaluation;
  evaluation.folder = arguments.data;
  evaluation.flags = &arguments.track;
  ASSIGN_OR_RETURN(evaluation.options, check_options(arguments));
  evaluation.degradation = arguments.degradation.degradation();
  ASSIGN_OR_RETURN(evaluation.read, read_options(arguments));
  ASSIGN_OR_RETURN(const TrackReport report, score_tracks(evaluation));
  return write(arguments, to_json(report), to_text(report), output);
}

absl::Status run(const EvalArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(arguments.json.announce(output));
  RETURN_IF_ERROR(arguments.pages.announce(output));
  if (arguments.track.track) return run_tracks(arguments, output);
  if (!arguments.compare.empty()) return run_comparison(arguments, output);
  if (!arguments.data.empty()) return run_evaluation(arguments, output);
  return absl::InvalidArgumentError("--data or --compare is needed: what shall be scored?");
}

}  // namespace

void add_eval_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "eval", "Score a method on scenes with ground truth, or compare two results", help(), run);
}

}  // namespace segserve::segctl
