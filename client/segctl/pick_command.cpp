// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/prompt_flags.hpp"
#include "client/segctl/saved_result.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "nlohmann/json.hpp"
#include "proto/text/result_json.hpp"
#include "segserve/prompts.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

HelpText help() {
  return {
      .common = {"--cloud", "--include", "--exclude", "--larger", "--smaller", "--output", "--json"},
      .examples = R"(segctl segment scene.pcd --result scene.segres
segctl pick scene.segres --cloud scene.pcd --include 320,240 --json -
segctl pick scene.segres --cloud scene.pcd --include 0.1,0,0.8 --exclude 0.1,0.2,0.9 -o object.ply --drop-unlabeled
segctl pick scene.segres --cloud scene.pcd --include 320,240 --larger 1 --picture object.png)",
      .details =
          R"(A place is a position X,Y,Z in the coordinates and unit of the cloud's file, or a pixel U,V (column and row) if
the cloud is an image. The fewest nodes of the merge tree are picked that hold all included places and no excluded one.
There are several such choices, from small to large. The one is taken that the cut of the result makes, or that of
--threshold or --regions; --larger and --smaller go to the next ones. JSON lists all. Picked points have the label 1,
all others 0.)",
      .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad input or usage."};
}

struct PickArguments {
  std::string result_path;
  std::string cloud_path;
  PromptFlags prompts;
  OptionFlags cut;
  SceneOutput scene_output;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app);
};

void PickArguments::add_to(CLI::App& app) {
  app.add_option("RESULT", result_path, "what segctl segment --result saved; - is standard input")
      ->type_name("FILE")
      ->required();
  app.add_option("--cloud", cloud_path, "the cloud that was segmented")->type_name("SCENE")->required();
  prompts.add_to(app, true);
  cut.add_cut_to(app);
  scene_output.add_to(app);
  json.add_to(app, "write what was picked as one JSON object");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

/// Takes the cut that the flags tell instead of that of the result.
absl::Status take_cut(const PickArguments& arguments, client::Result& result) {
  ASSIGN_OR_RETURN(const Options flags, arguments.cut.options());
  if (flags.regions || flags.threshold) result.regions = flags.regions;
  if (flags.threshold) result.segmentation.threshold = flags.threshold;
  return absl::OkStatus();
}

Json to_json(const PromptedSelection& picked, const Prompts& prompts, const MergeTree& tree) {
  Json json = text::selection_json(picked, prompts, tree);
  Json& candidates = json["candidates"] = Json::array();
  std::vector<std::uint32_t> nodes = picked.selection.smallest;
  for (std::size_t k = 0; k < picked.selection.candidates(); ++k) {
    if (k > 0) nodes[picked.selection.steps[k - 1].group] = picked.selection.steps[k - 1].node;
    candidates.push_back(text::candidate_json(tree, nodes, thresholds_of(tree, picked.selection, k)));
  }
  return json;
}

absl::Status run(const PickArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(output.protect({arguments.result_path}, true));
  RETURN_IF_ERROR(output.protect({arguments.cloud_path}));
  RETURN_IF_ERROR(arguments.scene_output.check_cloud_flags(false));
  RETURN_IF_ERROR(arguments.scene_output.announce(output));
  RETURN_IF_ERROR(arguments.json.announce(output));
  ASSIGN_OR_RETURN(const Prompts prompts, arguments.prompts.prompts());
  ASSIGN_OR_RETURN(SavedResult saved, load_saved_result(arguments.result_path));
  std::vector<codec::Warning> warnings;
  ASSIGN_OR_RETURN(const auto scene,
                   load_segmented_cloud(arguments.cloud_path, saved, input_name(arguments.result_path), warnings));
  RETURN_IF_ERROR(take_cut(arguments, saved.result));
  ASSIGN_OR_RETURN(auto picked, select_by_prompts(scene.cloud, saved.result.segmentation, saved.result.regions,
                                                  codec::to_cloud(scene.placement, prompts)));
  RETURN_IF_ERROR(describe(scene.cloud, 1, StopToken(), picked));
  codec::to_file(scene.placement, picked);
  RETURN_IF_ERROR(arguments.scene_output.add(output, scene, picked.labels, warnings));
  return report(
      Told{to_json(picked, prompts, saved.result.segmentation.tree), selection_text(picked), std::move(warnings)},
      arguments.json, arguments.quiet, output);
}

}  // namespace

void add_pick_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "pick", "Pick an object of a saved result by points on it and beside it", help(), run);
}

}  // namespace segserve::segctl
