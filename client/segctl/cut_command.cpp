#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/option_flags.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "fmt/format.h"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/segment.hpp"

namespace segserve::segctl {
namespace {

constexpr const char* kFooter = R"(Examples:
  segctl segment scene.pcd --result scene.segres
  segctl cut scene.segres --threshold 0.25
  segctl cut scene.segres --regions 8 --cloud scene.pcd -o labelled.ply --picture segments.png

The saved result is one line of text, "segserve-result 2 BYTES CRC32", where BYTES is the size of
the rest and CRC32 its checksum in hexadecimal, and then a segserve.v1.SegmentResponse
(protobuf) with labels, supervoxels and merge tree: to read it elsewhere, drop the first line.

Exit codes: 0 done; 1 failed (disk full); 2 bad input or usage.)";

struct Arguments {
  std::string result_path;
  OptionFlags cut;
  std::string cloud_path;
  SceneOutput scene_output;
  bool segments = false;
  std::string json_path;
  bool quiet = false;
};

void add_flags(CLI::App& app, Arguments& arguments) {
  app.add_option("RESULT", arguments.result_path, "what segctl segment --result saved; - is standard input")
      ->required();
  arguments.cut.add_cut_to(app);
  app.add_option("--cloud", arguments.cloud_path, "the cloud that was segmented, for -o, --picture and --segments")
      ->type_name("SCENE")
      ->group("Output");
  arguments.scene_output.add_to(app, true);
  app.add_option("--json", arguments.json_path, "write the summary as one JSON object; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("--segments", arguments.segments,
               "tell points, centroid, oriented box and mean colour of every segment in --json (the normals of a new "
               "cut are not known)")
      ->group("Output");
  app.add_flag("-q,--quiet", arguments.quiet, "print no summary")->group("Output");
}

absl::Status announce_outputs(const Arguments& arguments, StagedOutput& output) {
  if (arguments.scene_output.wanted() && arguments.cloud_path.empty()) {
    return absl::InvalidArgumentError("-o and --picture need --cloud, the cloud that was segmented");
  }
  if (arguments.segments && (arguments.cloud_path.empty() || arguments.json_path.empty())) {
    return absl::InvalidArgumentError("--segments needs --cloud, the cloud that was segmented, and --json");
  }
  if (absl::Status status = arguments.scene_output.announce(output); !status.ok()) return status;
  return arguments.json_path.empty() ? absl::OkStatus() : output.announce(arguments.json_path);
}

absl::StatusOr<client::Result> load_result(const std::string& path) {
  const auto bytes = read_input(path);
  if (!bytes.ok()) return bytes.status();
  auto result = client::decode_result_file(*bytes);
  if (result.ok()) return result;
  return absl::InvalidArgumentError(fmt::format("{}: {}", input_name(path), std::string(result.status().message())));
}

/// Replaces the cut of a result.
absl::Status recut(client::Result& result, const Options& options) {
  const MergeTree& tree = result.segmentation.tree;
  const auto cut =
      options.regions ? cut_to_regions(tree, *options.regions) : cut_at_threshold(tree, *options.threshold);
  if (!cut.ok()) return cut.status();
  auto labels = label_points(result.segmentation.supervoxels, *cut);
  if (!labels.ok()) return labels.status();
  result.segmentation.labels = *std::move(labels);
  result.segmentation.segments = cut->segments;
  result.segmentation.statistics.clear();  // they were of the other cut
  result.segmentation.threshold = options.threshold;
  result.regions = options.regions;
  return absl::OkStatus();
}

/// What needs the points: the labelled cloud, its picture, the segments' statistics.
absl::Status add_scene(const Arguments& arguments, client::Result& result, StagedOutput& output) {
  const auto scene = codec::load_cloud(arguments.cloud_path, result.view);
  if (!scene.ok()) return scene.status();
  if (scene->cloud.size() != result.points) {
    return absl::InvalidArgumentError(fmt::format("{} has {} points, but the saved result is of {}",
                                                  arguments.cloud_path, scene->cloud.size(), result.points));
  }
  if (arguments.scene_output.wanted()) {
    arguments.scene_output.add(output, scene->cloud, result.segmentation.labels);
  }
  return arguments.segments ? describe(scene->cloud, 1, StopToken(), result.segmentation) : absl::OkStatus();
}

absl::Status run(const Arguments& arguments) {
  StagedOutput output;
  if (absl::Status status = announce_outputs(arguments, output); !status.ok()) return status;
  const auto options = arguments.cut.options();
  if (!options.ok()) return options.status();
  if (!options->threshold && !options->regions) {
    return absl::InvalidArgumentError("--threshold or --regions is needed: where shall the tree be cut?");
  }
  auto result = load_result(arguments.result_path);
  if (!result.ok()) return result.status();

  const auto start = std::chrono::steady_clock::now();
  if (absl::Status status = recut(*result, *options); !status.ok()) return status;
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;

  if (arguments.scene_output.wanted() || arguments.segments) {
    if (absl::Status status = add_scene(arguments, *result, output); !status.ok()) return status;
  }
  const Summary summary{.result = *result,
                        .input = input_name(arguments.result_path),
                        .server = "",
                        .timings = {{"cut", time.count()}, {"total", time.count()}},
                        .with_segments = arguments.segments};
  return report(summary, arguments.json_path, arguments.quiet, output);
}

}  // namespace

void add_cut_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("cut", "Cut a saved result at another threshold or number of regions");
  auto arguments = std::make_shared<Arguments>();
  add_flags(*command, *arguments);
  command->footer(kFooter);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
