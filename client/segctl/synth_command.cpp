// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/camera_rig.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/output_folder.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/rgbd_output.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/sequence.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "command_line/not_negative.hpp"
#include "core/base/status_macros.hpp"
#include "core/lab/synth/moving_tabletop.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/table_rig.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kFirstObjectLabel = 20;

const std::map<std::string, synth::Sensor>& sensors() {
  static const std::map<std::string, synth::Sensor> kSensors{{"kinect1", synth::Sensor::kKinect1},
                                                             {"stereo", synth::Sensor::kStereo},
                                                             {"passive-stereo", synth::Sensor::kPassiveStereo},
                                                             {"tof", synth::Sensor::kTimeOfFlight},
                                                             {"ideal", synth::Sensor::kIdeal}};
  return kSensors;
}

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

struct SynthArguments {
  synth::SceneOptions table;
  synth::RoomViewOptions room_view;
  synth::RoomOptions room;
  synth::LidarOptions lidar;
  synth::MovingOptions moving;
  std::string moving_folder;
  std::string rig_folder;
  std::uint32_t cameras = 2;
  std::uint64_t seed = 1;
  double noise = 1;
  std::optional<std::uint32_t> objects;
  std::optional<double> size;
  std::string sensor = "kinect1";
  std::uint32_t width = 640, height = 480;
  bool sees_room = false;
  bool fused = false;
  std::optional<std::uint32_t> rings;
  bool furnished = false;
  bool no_holes = false;
  SceneOutput scene_output;
  RgbdOutput rgbd_output;
  JsonFlag json;
  bool quiet = false;

  void add_to(CLI::App& app);

 private:
  void add_scene_flags(CLI::App& app);
  void add_moving_flags(CLI::App& app);
  void add_rig_flags(CLI::App& app);
};

/// The flags of every scene, and those that choose its kind.
void SynthArguments::add_scene_flags(CLI::App& app) {
  app.add_option("--seed", seed, "seed of everything that is random")
      ->check(not_negative())
      ->capture_default_str()
      ->group("Scene");
  app.add_option("--noise", noise, "factor on the noise of the sensor, 0 to 10")->capture_default_str()->group("Scene");
  app.add_option("--objects", objects,
                 fmt::format("number of small objects; default {} on a table, {} with --room-view, {} with --fused, {} "
                             "with --lidar",
                             table.objects, room_view.objects, room.objects, lidar.objects))
      ->check(not_negative())
      ->group("Scene");
  app.add_option("--size", size,
                 fmt::format("factor on the edges of a room of 3.3 m x 2.8 m, 0.7 to 10; default {} with --room-view, "
                             "{} with --fused, {} with --lidar",
                             room_view.size, room.size, lidar.size))
      ->group("Scene");
}

void SynthArguments::add_moving_flags(CLI::App& app) {
  const std::string group = "Over time";
  CLI::Option* folder =
      app.add_option("--moving", moving_folder,
                     "write the frames of a table over time to DIR/frame_0000.pcd and so on, and when "
                     "and from where they were taken to DIR/sequence.json")
          ->type_name("DIR")
          ->group(group);
  const auto option = [&](const char* flag, auto& value, const char* text) {
    app.add_option(flag, value, text)->needs(folder)->capture_default_str()->group(group);
  };
  option("--rate", moving.rate, "frames a second, 0.1 to 120");
  option("--frames", moving.frames, "how many frames, 1 to 100000");
  option("--camera-motion", moving.camera_motion, "factor on the motion of the camera, 0 to 5; 1: about 0.2 m/s");
  option("--moving-objects", moving.moving, "how many objects slide over the table, 0 to 40");
  option("--speed", moving.speed, "highest speed of these objects, m/s, 0 to 2");
}

void SynthArguments::add_rig_flags(CLI::App& app) {
  const std::string group = "Several cameras";
  CLI::Option* folder = app.add_option("--rig", rig_folder,
                                       "write what several cameras around a table see to DIR/camera_0.pcd and so on, "
                                       "and where they stand to DIR/cameras.json")
                            ->type_name("DIR")
                            ->group(group);
  app.add_option("--cameras", cameras, "how many cameras, at equal angles around the table, 1 to 16")
      ->needs(folder)
      ->capture_default_str()
      ->group(group);
}

void SynthArguments::add_to(CLI::App& app) {
  add_moving_flags(app);
  add_rig_flags(app);
  const std::string table_group = "Table seen by a camera";
  const std::string camera_group = "Camera";
  const std::string room_group = "Rooms";
  const std::string lidar_group = "LiDAR";
  add_scene_flags(app);
  app.add_flag("--furnished", furnished, "more kinds of furniture: sofas, beds, desks, office chairs, stools, lamps")
      ->group(room_group);
  CLI::Option* view_flag =
      app.add_flag("--room-view", sees_room, "a camera that looks across a room, instead of a table")
          ->group(room_group);
  CLI::Option* fused_flag = app.add_flag("--fused", fused, "a room fused from many views, in one WORLD cloud")
                                ->excludes(view_flag)
                                ->group(room_group);
  CLI::Option* lidar_flag = app.add_option("--lidar", rings, "a turn of a LiDAR with 16, 32, 64 or 128 rings in a room")
                                ->type_name("RINGS")
                                ->check(not_negative())
                                ->excludes(view_flag)
                                ->excludes(fused_flag)
                                ->group(lidar_group);
  app.add_flag("--street", lidar.street, "on a street with cars and pedestrians, instead of a room")
      ->needs(lidar_flag)
      ->group(lidar_group);
  app.add_option("--columns", lidar.columns, "directions a turn, 64 to 8192")
      ->check(not_negative())
      ->capture_default_str()
      ->needs(lidar_flag)
      ->group(lidar_group);
  app.add_flag("--organized", lidar.organized, "one row a ring, with NaN where there is no echo")
      ->needs(lidar_flag)
      ->group(lidar_group);
  app.add_option("--points", room.points, "number of points with --fused, 1000 to 20 million")
      ->check(not_negative())
      ->capture_default_str()
      ->needs(fused_flag)
      ->group(room_group);
  const auto of_camera = [&](CLI::Option* option) {
    return option->excludes(fused_flag)->excludes(lidar_flag)->group(camera_group);
  };
  of_camera(app.add_option("--sensor", sensor, "what measures depth: kinect1, stereo, passive-stereo, tof or ideal"))
      ->capture_default_str()
      ->check(CLI::IsMember(sensors()));
  of_camera(app.add_option("--width", width, "width of the image in pixels, 16 to 4096"))
      ->capture_default_str()
      ->check(not_negative());
  of_camera(app.add_option("--height", height, "height of the image in pixels, 16 to 4096"))
      ->capture_default_str()
      ->check(not_negative());
  of_camera(app.add_flag("--no-holes", no_holes, "no points without depth where the sensor cannot measure"));
  rgbd_output.add_to(app, camera_group);
  const auto of_table = [&](CLI::Option* option) {
    option->excludes(fused_flag)->excludes(view_flag)->excludes(lidar_flag)->group(table_group);
  };
  const auto table_option = [&](const std::string& flag, double& value, const std::string& help) {
    of_table(app.add_option(flag, value, help)->capture_default_str());
  };
  table_option("--stacked", table.stacked, "share of the objects on top of others, 0 to 1");
  table_option("--clutter", table.clutter, "0: objects spread over the table, 1: crowded");
  table_option("--distance", table.distance, "factor on the usual distance of the camera, 0.5 to 3");
  of_table(app.add_flag("--hollow", table.hollow, "only bowls, cups, open boxes, plates, cables and their like"));
  of_table(app.add_flag("--compact", table.compact, "only boxes, books, cans, bottles and their like"));
  of_table(app.add_flag("--all-finite", table.all_finite, "a wall behind the table: every pixel is a point"));
  scene_output.add_to(app);
  json.add_to(app, "write what the scene holds as one JSON object");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
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

/// Sets what the table and the room that a camera sees have in common.
template <typename CameraOptions>
CameraOptions with_camera(const SynthArguments& arguments, CameraOptions options) {
  options.seed = arguments.seed;
  options.noise = arguments.noise;
  options.objects = arguments.objects.value_or(options.objects);
  options.sensor = sensors().at(arguments.sensor);
  options.width = arguments.width;
  options.height = arguments.height;
  options.holes = !arguments.no_holes;
  return options;
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

/// Writes a file of its own.
absl::Status write_file(const std::string& folder, const std::string& name, std::string bytes) {
  const std::string path = (std::filesystem::path(folder) / name).string();
  StagedOutput output;
  RETURN_IF_ERROR(output.announce(path));
  output.add(path, std::move(bytes));
  return output.commit();
}

/// Tells what a folder has got.
absl::Status tell(const SynthArguments& arguments, const Json& json, const std::string& text) {
  StagedOutput output;
  RETURN_IF_ERROR(arguments.json.announce(output));
  return report(Told{json, text}, arguments.json, arguments.quiet, output);
}

absl::Status write_rig(const SynthArguments& arguments) {
  ASSIGN_OR_RETURN(const auto views,
                   synth::make_tabletop_rig(with_camera(arguments, arguments.table), arguments.cameras));
  RETURN_IF_ERROR(make_folder(arguments.rig_folder));
  std::vector<RigCamera> cameras;
  std::set<std::uint32_t> objects;
  for (const synth::RigView& view : views) {
    cameras.push_back({fmt::format("camera_{}.pcd", cameras.size()), view.pose});
    codec::LabeledCloud content;
    content.cloud = view.scene.cloud;
    RETURN_IF_ERROR(write_file(arguments.rig_folder, cameras.back().file,
                               arguments.scene_output.encode_pcd(content, view.scene.label)));
    for (const std::uint32_t label : view.scene.label) {
      if (label >= kFirstObjectLabel) objects.insert(label);
    }
  }
  RETURN_IF_ERROR(write_file(arguments.rig_folder, kRigFile, rig_json(cameras)));
  return tell(arguments, Json{{"cameras", cameras.size()}, {"objects", objects.size()}, {"seed", arguments.seed}},
              fmt::format("{}: {} cameras, {} objects\n", arguments.rig_folder, cameras.size(), objects.size()));
}

/// Writes frame by frame, because a long sequence does not fit into memory.
absl::Status write_moving(const SynthArguments& arguments) {
  synth::MovingOptions options = arguments.moving;
  options.scene = with_camera(arguments, arguments.table);
  ASSIGN_OR_RETURN(const auto scene, synth::MovingTabletop::make(options));
  RETURN_IF_ERROR(make_folder(arguments.moving_folder));
  const ProgressBar bar("synth");
  std::vector<SequenceFrame> frames;
  for (std::uint32_t i = 0; i < scene.frames(); ++i) {
    const synth::MovingFrame frame = scene.frame(i);
    frames.push_back({fmt::format("frame_{:04}.pcd", i), frame.time, frame.pose});
    codec::LabeledCloud content;
    content.cloud = frame.scene.cloud;
    RETURN_IF_ERROR(write_file(arguments.moving_folder, frames.back().file,
                               arguments.scene_output.encode_pcd(content, frame.scene.label)));
    bar.show(i + 1, scene.frames());
  }
  RETURN_IF_ERROR(write_file(arguments.moving_folder, kSequenceFile, sequence_json(frames)));
  return tell(arguments, Json{{"frames", frames.size()}, {"rate", options.rate}, {"moving", scene.moving()}},
              fmt::format("{}: {} frames, {} objects move\n", arguments.moving_folder, frames.size(), scene.moving()));
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

absl::Status run(const SynthArguments& arguments) {
  const bool is_moving = !arguments.moving_folder.empty();
  if (is_moving || !arguments.rig_folder.empty()) {
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
    return is_moving ? write_moving(arguments) : write_rig(arguments);
  }
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
  StagedOutput output;
  RETURN_IF_ERROR(arguments.scene_output.check_cloud_flags(false));
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
