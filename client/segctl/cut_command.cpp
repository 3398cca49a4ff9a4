// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <string>

#include "client/segctl/command.hpp"
#include "client/segctl/dendrogram_flag.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/saved_result.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/split_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/segment.hpp"

namespace segserve::segctl {
namespace {

HelpText help() {
  return {
      .common = {"--threshold", "--regions", "--cloud", "--output", "--drop-unlabeled", "--split", "--picture",
                 "--dendrogram", "--segments", "--json"},
      .examples = R"(segctl segment scene.pcd --result scene.segres
segctl cut scene.segres --threshold 0.25
segctl cut scene.segres --regions 8 --cloud scene.pcd -o labeled.ply --picture segments.png
segctl cut scene.segres --threshold 0.1 --dendrogram tree.png)",
      .details =
          R"(A saved result is one line of text, "segserve-result 3 BYTES CRC32 COORDINATES COLORS", where BYTES is the size of
the rest and CRC32 its checksum in hexadecimal, followed by a segserve.v1.SegmentResponse (protobuf) with labels,
supervoxels and merge tree. To read it elsewhere, drop the first line. COORDINATES and COLORS are checksums of the
points that were segmented, by which --cloud refuses another cloud. The cloud may be in another file format now.
Version 2, without these checksums, is read with a warning.)",
      .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad input or usage."};
}

struct CutArguments {
  std::string result_path;
  OptionFlags cut;
  std::string cloud_path;
  SceneOutput scene_output;
  SplitOutput split_output;
  DendrogramFlag dendrogram;
  bool segments = false;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app);
  bool needs_points() const { return scene_output.wanted() || split_output.wanted(); }
};

void CutArguments::add_to(CLI::App& app) {
  app.add_option("RESULT", result_path, "what segctl segment --result saved; - is standard input")
      ->type_name("FILE")
      ->required();
  cut.add_cut_to(app);
  app.add_option("--cloud", cloud_path, "the cloud that was segmented, for -o, --split, the pictures and --segments")
      ->type_name("SCENE")
      ->group("Output");
  scene_output.add_to(app);
  split_output.add_to(app);
  dendrogram.add_to(app);
  app.add_flag("--segments", segments,
               "tell points, centroid, oriented box and mean color of every segment in --json (the normals of a new "
               "cut are not known)")
      ->group("Output");
  json.add_to(app, "write the summary as one JSON object");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

absl::Status announce_outputs(const CutArguments& arguments, StagedOutput& output) {
  if (arguments.needs_points() && arguments.cloud_path.empty()) {
    return absl::InvalidArgumentError(
        "-o, --split, --picture and --plain-picture need --cloud, the cloud that was segmented");
  }
  if (arguments.segments && (arguments.cloud_path.empty() || !arguments.json.given())) {
    return absl::InvalidArgumentError("--segments needs --cloud, the cloud that was segmented, and --json");
  }
  RETURN_IF_ERROR(arguments.scene_output.check_cloud_flags(arguments.split_output.wanted()));
  RETURN_IF_ERROR(arguments.scene_output.announce(output));
  RETURN_IF_ERROR(arguments.split_output.announce(output));
  RETURN_IF_ERROR(arguments.dendrogram.announce(output));
  return arguments.json.announce(output);
}

/// Replaces the labels of a result by those of another cut of its tree.
absl::Status recut(client::Result& result, const Options& options) {
  const MergeTree& tree = result.segmentation.tree;
  ASSIGN_OR_RETURN(const auto cut, options.regions ? cut_to_regions(tree, *options.regions)
                                                   : cut_at_threshold(tree, *options.threshold));
  ASSIGN_OR_RETURN(result.segmentation.labels, label_points(result.segmentation.supervoxels, cut));
  result.segmentation.segments = cut.segments;
  result.segmentation.statistics.clear();  // They describe the segments of the old cut.
  result.segmentation.threshold = options.threshold;
  result.regions = options.regions;
  return absl::OkStatus();
}

/// Adds what needs the points: the labeled cloud, its pictures, the statistics of the segments.
absl::Status add_scene(const CutArguments& arguments, SavedResult& saved, StagedOutput& output) {
  client::Result& result = saved.result;
  ASSIGN_OR_RETURN(const auto scene, load_segmented_cloud(arguments.cloud_path, saved,
                                                          input_name(arguments.result_path), result.warnings));
  RETURN_IF_ERROR(arguments.scene_output.add(output, scene, result.segmentation.labels, result.warnings));
  RETURN_IF_ERROR(
      arguments.split_output.add(output, scene, result.segmentation.labels, arguments.scene_output, result.warnings));
  RETURN_IF_ERROR(arguments.dendrogram.add(output, result, &scene, arguments.scene_output));
  if (!arguments.segments) return absl::OkStatus();
  RETURN_IF_ERROR(describe(scene.cloud, 1, StopToken(), result.segmentation));
  for (SegmentStatistics& segment : result.segmentation.statistics) codec::to_file(scene.placement, segment);
  return absl::OkStatus();
}

absl::Status run(const CutArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(output.protect({arguments.result_path}, true));
  if (!arguments.cloud_path.empty()) RETURN_IF_ERROR(output.protect({arguments.cloud_path}));
  RETURN_IF_ERROR(announce_outputs(arguments, output));
  ASSIGN_OR_RETURN(const Options options, arguments.cut.options());
  if (!options.threshold && !options.regions) {
    return absl::InvalidArgumentError("--threshold or --regions is needed: where shall the tree be cut?");
  }
  ASSIGN_OR_RETURN(SavedResult saved, load_saved_result(arguments.result_path));

  const auto start = std::chrono::steady_clock::now();
  RETURN_IF_ERROR(recut(saved.result, options));
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;

  if (!arguments.cloud_path.empty() &&
      (arguments.needs_points() || arguments.segments || arguments.dendrogram.given())) {
    RETURN_IF_ERROR(add_scene(arguments, saved, output));
  } else {
    RETURN_IF_ERROR(arguments.dendrogram.add(output, saved.result, nullptr, arguments.scene_output));
  }
  const Summary summary{.result = saved.result,
                        .input = input_name(arguments.result_path),
                        .server = "",
                        .timings = {{"cut", time.count()}, {"total", time.count()}},
                        .with_segments = arguments.segments};
  return report(summary, arguments.json, arguments.quiet, output);
}

}  // namespace

void add_cut_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "cut", "Cut a saved result at another threshold or number of regions", help(), run);
}

}  // namespace segserve::segctl
