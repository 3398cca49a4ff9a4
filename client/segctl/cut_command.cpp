// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/messages.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/split_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "segserve/client/cloud_fingerprint.hpp"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/segment.hpp"

namespace segserve::segctl {
namespace {

HelpText help() {
  return {
      .common = {"--threshold", "--regions", "--cloud", "--output", "--drop-unlabelled", "--split", "--picture",
                 "--segments", "--json"},
      .examples = R"(segctl segment scene.pcd --result scene.segres
segctl cut scene.segres --threshold 0.25
segctl cut scene.segres --regions 8 --cloud scene.pcd -o labeled.ply --picture segments.png)",
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
  RETURN_IF_ERROR(arguments.scene_output.announce(output));
  RETURN_IF_ERROR(arguments.split_output.announce(output));
  return arguments.json.announce(output);
}

struct SavedResult {
  client::Result result;
  std::optional<client::CloudFingerprint> cloud;  ///< Unset in files of version 2.
};

absl::StatusOr<SavedResult> load_result(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, read_input(path));
  auto result = client::decode_result_file(bytes);
  if (!result.ok()) return with_prefix(input_name(path), result.status());
  ASSIGN_OR_RETURN(const auto cloud, client::fingerprint_in_result_file(bytes));
  return SavedResult{*std::move(result), cloud};
}

/// INVALID_ARGUMENT if it is plain that the result is of another cloud.
absl::Status check_cloud(const CutArguments& arguments, const SavedResult& saved, const CloudView& cloud) {
  const std::string cloud_name = input_name(arguments.cloud_path), result_name = input_name(arguments.result_path);
  if (cloud.size() != saved.result.points) {
    return absl::InvalidArgumentError(fmt::format("{} has {} points, but the saved result has {}: it is another cloud",
                                                  cloud_name, cloud.size(), saved.result.points));
  }
  if (!saved.cloud) {
    print_warning(
        fmt::format("{} was saved by an older segctl and does not tell which cloud it belongs to: it is not "
                    "checked that this is {}",
                    result_name, cloud_name));
    return absl::OkStatus();
  }
  const client::CloudFingerprint print = client::fingerprint(cloud);
  if (print.coordinates != saved.cloud->coordinates) {
    return absl::InvalidArgumentError(
        fmt::format("{} is not the cloud that was segmented for {}: it has as many points, but other ones", cloud_name,
                    result_name));
  }
  if (print.colors != saved.cloud->colors) {
    print_warning(fmt::format("{} has other colors than the cloud that was segmented", cloud_name));
  }
  return absl::OkStatus();
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

/// Reads the cloud as it was read when it was segmented.
codec::ReadOptions read_options(const client::Result& result) {
  codec::ReadOptions options{.view = result.view, .keep_everything = true};
  for (const codec::LengthUnit unit : codec::length_units()) {
    if (codec::meters_per_unit(unit) == result.placement.meters_per_unit()) options.unit = unit;
  }
  return options;
}

/// Adds what needs the points: the labeled cloud, its pictures, the statistics of the segments.
absl::Status add_scene(const CutArguments& arguments, SavedResult& saved, StagedOutput& output) {
  client::Result& result = saved.result;
  ASSIGN_OR_RETURN(const auto scene, codec::load_cloud(arguments.cloud_path, read_options(result)));
  RETURN_IF_ERROR(check_cloud(arguments, saved, scene.cloud));
  RETURN_IF_ERROR(arguments.scene_output.add(output, scene, result.segmentation.labels));
  RETURN_IF_ERROR(arguments.split_output.add(output, scene, result.segmentation.labels, arguments.scene_output));
  if (!arguments.segments) return absl::OkStatus();
  RETURN_IF_ERROR(describe(scene.cloud, 1, StopToken(), result.segmentation));
  for (SegmentStatistics& segment : result.segmentation.statistics) codec::to_file(scene.placement, segment);
  return absl::OkStatus();
}

absl::Status run(const CutArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(announce_outputs(arguments, output));
  ASSIGN_OR_RETURN(const Options options, arguments.cut.options());
  if (!options.threshold && !options.regions) {
    return absl::InvalidArgumentError("--threshold or --regions is needed: where shall the tree be cut?");
  }
  ASSIGN_OR_RETURN(SavedResult saved, load_result(arguments.result_path));

  const auto start = std::chrono::steady_clock::now();
  RETURN_IF_ERROR(recut(saved.result, options));
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;

  if (arguments.needs_points() || arguments.segments) RETURN_IF_ERROR(add_scene(arguments, saved, output));
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
