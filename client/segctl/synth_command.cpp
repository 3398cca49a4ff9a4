// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include "client/segctl/command.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/rgbd_output.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "command_line/not_negative.hpp"
#include "core/base/status_macros.hpp"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kFirstObjectLabel = 20;

HelpText help() {
  return {
      .common = {"--seed", "--objects", "--noise", "--width", "--height", "--fused", "--points", "--depth", "--rgb",
                 "--output", "--picture", "--plain-picture", "--json"},
      .examples = R"(segctl synth -o table.pcd --plain-picture table.png
segctl synth --seed 7 --objects 12 --noise 0 -o table.ply --picture ground_truth.png
segctl synth --depth depth.png --rgb color.jpg
segctl synth --fused --points 1000000 -o room.pcd)",
      .details =
          R"(The same flags give the same bytes on every machine. Ground truth is the field "label": 0 for no point, 1 to 9 for
table, floor and walls, 20, 30, 40 and so on for objects. Images carry no ground truth.)",
      .exit_codes = "0 success; 1 the operation failed (disk full); 2 bad usage."};
}

struct SynthArguments {
  synth::SceneOptions table;
  synth::RoomOptions room;
  std::uint64_t seed = 1;
  double noise = 1;
  CLI::Option* objects_flag = nullptr;
  std::uint32_t objects = 0;
  bool fused = false;
  bool no_holes = false;
  SceneOutput scene_output;
  RgbdOutput rgbd_output;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app);
};

void SynthArguments::add_to(CLI::App& app) {
  const std::string table_group = "Table seen by a camera";
  const std::string room_group = "Room fused from many views";
  app.add_option("--seed", seed, "seed of everything that is random")
      ->check(not_negative())
      ->capture_default_str()
      ->group("Scene");
  app.add_option("--noise", noise, "factor on the noise of a Kinect, 0 to 10")->capture_default_str()->group("Scene");
  objects_flag =
      app.add_option("--objects", objects,
                     fmt::format("number of objects; default {}, {} with --fused", table.objects, room.objects))
          ->check(not_negative())
          ->group("Scene");
  CLI::Option* fused_flag =
      app.add_flag("--fused", fused, "a room in one WORLD cloud, instead of a table")->group(room_group);
  const auto table_option = [&](const std::string& flag, auto& value, const std::string& help) {
    return app.add_option(flag, value, help)->capture_default_str()->excludes(fused_flag)->group(table_group);
  };
  const auto room_option = [&](const std::string& flag, auto& value, const std::string& help) {
    return app.add_option(flag, value, help)->capture_default_str()->needs(fused_flag)->group(room_group);
  };
  table_option("--width", table.width, "width of the image in pixels, 16 to 4096")->check(not_negative());
  table_option("--height", table.height, "height of the image in pixels, 16 to 4096")->check(not_negative());
  table_option("--stacked", table.stacked, "share of the objects on top of others, 0 to 1");
  table_option("--clutter", table.clutter, "0: objects spread over the table, 1: crowded");
  table_option("--distance", table.distance, "factor on the usual distance of the camera, 0.5 to 3");
  app.add_flag("--no-holes", no_holes, "no points without depth on the table")
      ->excludes(fused_flag)
      ->group(table_group);
  app.add_flag("--all-finite", table.all_finite, "a wall behind the table: every pixel is a point")
      ->excludes(fused_flag)
      ->group(table_group);
  rgbd_output.add_to(app, table_group);
  room_option("--points", room.points, "number of points, 1000 to 20 million")->check(not_negative());
  room_option("--size", room.size, "factor on the usual edges of the room, 0.7 to 10");
  scene_output.add_to(app);
  json.add_to(app, "write what the scene holds as one JSON object");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

absl::StatusOr<synth::SyntheticScene> make_scene(const SynthArguments& arguments) {
  const bool objects_given = arguments.objects_flag->count() > 0;
  if (arguments.fused) {
    synth::RoomOptions room = arguments.room;
    room.seed = arguments.seed;
    room.noise = arguments.noise;
    if (objects_given) room.objects = arguments.objects;
    return synth::make_fused_room(room);
  }
  synth::SceneOptions table = arguments.table;
  table.seed = arguments.seed;
  table.noise = arguments.noise;
  table.holes = !arguments.no_holes;
  if (objects_given) table.objects = arguments.objects;
  return synth::make_tabletop(table);
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

Json to_json(const SynthArguments& arguments, const synth::SyntheticScene& scene) {
  Json json{{"width", scene.cloud.width},      {"height", scene.cloud.height},
            {"points", scene.cloud.size()},    {"finite", count_finite(scene.cloud)},
            {"objects", count_objects(scene)}, {"seed", arguments.seed},
            {"intrinsics", nullptr},           {"depth_scale", nullptr}};
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

absl::Status run(const SynthArguments& arguments) {
  if (!arguments.scene_output.wanted() && !arguments.rgbd_output.wanted()) {
    return absl::InvalidArgumentError("-o, --depth, --picture or --plain-picture is needed: what shall be written?");
  }
  if (arguments.fused && arguments.rgbd_output.wanted()) {
    return absl::InvalidArgumentError(
        "--depth does not go with --fused: no camera sees a whole room; use -o for its points");
  }
  StagedOutput output;
  RETURN_IF_ERROR(arguments.scene_output.announce(output));
  RETURN_IF_ERROR(arguments.rgbd_output.announce(output));
  RETURN_IF_ERROR(arguments.json.announce(output));
  ASSIGN_OR_RETURN(const auto scene, make_scene(arguments));
  codec::LabeledCloud content;
  content.cloud = scene.cloud;
  RETURN_IF_ERROR(arguments.scene_output.add(output, content, scene.label));
  if (arguments.rgbd_output.wanted()) {
    RETURN_IF_ERROR(arguments.rgbd_output.add(output, scene.cloud, *scene.camera));
  }
  arguments.json.add(output, to_json(arguments, scene));
  if (!arguments.quiet && !output.uses_stdout()) output.add("-", to_text(arguments, scene));
  return output.commit();
}

}  // namespace

void add_synth_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "synth", "Make a synthetic RGB-D scene with ground truth", help(), run);
}

}  // namespace segserve::segctl
