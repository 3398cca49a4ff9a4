// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/command.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "client/segctl/synth_arguments.hpp"
#include "client/segctl/synth_folders.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

HelpText help() {
  return {
      .common = {"--seed",  "--objects", "--noise",  "--sensor",  "--width",         "--height", "--room-view",
                 "--fused", "--points",  "--lidar",  "--moving",  "--rate",          "--frames", "--street",
                 "--depth", "--rgb",     "--output", "--picture", "--plain-picture", "--json"},
      .examples = R"(segctl synth -o table.pcd --plain-picture table.png
segctl synth --seed 7 --objects 12 --noise 0 -o table.ply --picture ground_truth.png
segctl synth --depth depth.png --rgb color.jpg
segctl synth --room-view --sensor stereo -o far.pcd
segctl synth --fused --points 1000000 -o room.pcd
segctl synth --lidar 64 --street -o street.pcd
segctl synth --rig rig --cameras 3; segctl segment --cameras rig/cameras.json --out-dir labeled
segctl synth --moving moving --rate 10 --frames 100; segctl segment moving --track --json tracks.jsonl)",
      .details =
          R"(The same flags give the same bytes on every machine. Ground truth is the field "label": 0 for no point and for points
that lie on no surface, 1 to 9 for table, floor, ground, walls and facades, 20, 30, 40 and so on for objects. Images
carry no ground truth, and LiDAR sweeps no colors.)",
      .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad usage."};
}

absl::StatusOr<synth::SyntheticScene> make_fused_room(const SynthArguments& arguments) {
  synth::RoomOptions room = arguments.room;
  room.seed = arguments.seed;
  room.noise = arguments.noise;
  room.objects = arguments.objects.value_or(room.objects);
  room.size = arguments.size.value_or(room.size);
  room.furnished = arguments.furnished;
  return synth::make_fused_room(room);
}

absl::StatusOr<synth::SyntheticScene> make_lidar_sweep(const SynthArguments& arguments) {
  synth::LidarOptions lidar = arguments.lidar;
  lidar.seed = arguments.seed;
  lidar.noise = arguments.noise;
  lidar.rings = *arguments.rings;
  lidar.objects = arguments.objects.value_or(lidar.objects);
  lidar.size = arguments.size.value_or(lidar.size);
  lidar.furnished = arguments.furnished;
  return synth::make_lidar_sweep(lidar);
}

absl::StatusOr<synth::SyntheticScene> make_scene(const SynthArguments& arguments) {
  if (arguments.fused) return make_fused_room(arguments);
  if (arguments.rings) return make_lidar_sweep(arguments);
  if (arguments.sees_room) {
    synth::RoomViewOptions view = with_camera(arguments, arguments.room_view);
    view.size = arguments.size.value_or(view.size);
    view.furnished = arguments.furnished;
    return synth::make_room_view(view);
  }
  return synth::make_tabletop(with_camera(arguments, arguments.table));
}

std::size_t count_finite(const CloudView& cloud) {
  std::size_t finite = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) finite += is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) ? 1U : 0U;
  return finite;
}

std::size_t count_objects(const synth::SyntheticScene& scene) {
  std::set<std::uint32_t> objects;
  for (const std::uint32_t label : scene.label) {
    if (label >= kFirstObjectLabel) objects.insert(label / 10);  // Parts of one object differ in the last digit.
  }
  return objects.size();
}

/// The different labels of the ground truth, each of which is a region that eval scores.
std::size_t count_regions(const synth::SyntheticScene& scene) {
  std::set<std::uint32_t> regions(scene.label.begin(), scene.label.end());
  regions.erase(0);
  return regions.size();
}

Json to_json(const SynthArguments& arguments, const synth::SyntheticScene& scene) {
  Json json{{"width", scene.cloud.width},      {"height", scene.cloud.height},
            {"points", scene.cloud.size()},    {"finite", count_finite(scene.cloud)},
            {"objects", count_objects(scene)}, {"regions", count_regions(scene)},
            {"seed", arguments.seed},          {"intrinsics", nullptr},
            {"depth_scale", nullptr}};
  if (scene.camera) {
    const codec::Intrinsics& camera = *scene.camera;
    json["intrinsics"] = {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}};
  }
  if (arguments.rgbd_output.wanted()) json["depth_scale"] = arguments.rgbd_output.depth_scale();
  return json;
}

std::string to_text(const SynthArguments& arguments, const synth::SyntheticScene& scene) {
  std::string text = fmt::format("{} x {}: {} points, {} finite, {} objects\n", scene.cloud.width, scene.cloud.height,
                                 scene.cloud.size(), count_finite(scene.cloud), count_objects(scene));
  if (arguments.rgbd_output.wanted()) {
    text += fmt::format("images: segctl segment {}\n", arguments.rgbd_output.as_input_flags(*scene.camera));
  }
  return text;
}

/// Whether a folder is to be written, of several cameras or over time.
bool writes_folder(const SynthArguments& arguments) {
  return !arguments.moving_folder.empty() || !arguments.rig_folder.empty();
}

absl::Status check_folder_flags(const SynthArguments& arguments) {
  const bool is_moving = !arguments.moving_folder.empty();
  if (is_moving && !arguments.rig_folder.empty()) {
    return absl::InvalidArgumentError("--moving and --rig exclude each other");
  }
  if (arguments.scene_output.wanted() || arguments.rgbd_output.wanted() || arguments.fused || arguments.rings ||
      arguments.sees_room) {
    return absl::InvalidArgumentError(
        fmt::format("{} is for tables, and writes its own files: not together with -o, pictures, images, "
                    "--room-view, --fused and --lidar",
                    is_moving ? "--moving" : "--rig"));
  }
  return absl::OkStatus();
}

absl::Status check_scene_flags(const SynthArguments& arguments) {
  if (!arguments.scene_output.wanted() && !arguments.rgbd_output.wanted()) {
    return absl::InvalidArgumentError("-o, --depth, --picture or --plain-picture is needed: what shall be written?");
  }
  const bool is_room = arguments.sees_room || arguments.fused || (arguments.rings && !arguments.lidar.street);
  if ((arguments.size || arguments.furnished) && !is_room) {
    return absl::InvalidArgumentError(fmt::format("{} is for a room: it needs --room-view, --fused or --lidar",
                                                  arguments.size ? "--size" : "--furnished"));
  }
  if (arguments.fused && arguments.rgbd_output.wanted()) {
    return absl::InvalidArgumentError(
        "--depth does not go with --fused: no camera sees a whole room; use -o for its points");
  }
  if (arguments.rings && arguments.rgbd_output.wanted()) {
    return absl::InvalidArgumentError("--depth does not go with --lidar, which is no camera; use -o for its points");
  }
  return arguments.scene_output.check_cloud_flags(false);
}

absl::Status run(const SynthArguments& arguments) {
  if (writes_folder(arguments)) {
    RETURN_IF_ERROR(check_folder_flags(arguments));
    return arguments.rig_folder.empty() ? write_moving(arguments) : write_rig(arguments);
  }
  RETURN_IF_ERROR(check_scene_flags(arguments));
  StagedOutput output;
  RETURN_IF_ERROR(arguments.scene_output.announce(output));
  RETURN_IF_ERROR(arguments.rgbd_output.announce(output));
  RETURN_IF_ERROR(arguments.json.announce(output));
  ASSIGN_OR_RETURN(const auto scene, make_scene(arguments));
  codec::LabeledCloud content;
  content.cloud = scene.cloud;
  std::vector<codec::Warning> warnings;
  RETURN_IF_ERROR(arguments.scene_output.add(output, content, scene.label, warnings));
  if (arguments.rgbd_output.wanted()) {
    RETURN_IF_ERROR(arguments.rgbd_output.add(output, scene.cloud, *scene.camera));
  }
  return report(Told{to_json(arguments, scene), to_text(arguments, scene), std::move(warnings)}, arguments.json,
                arguments.quiet, output);
}

}  // namespace

void add_synth_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "synth", "Make a synthetic scene with ground truth", help(), run);
}

}  // namespace segserve::segctl
