// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/synth_arguments.hpp"

#include <map>

#include "command_line/not_negative.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

const std::map<std::string, synth::Sensor>& sensors() {
  static const std::map<std::string, synth::Sensor> kSensors{{"kinect1", synth::Sensor::kKinect1},
                                                             {"stereo", synth::Sensor::kStereo},
                                                             {"passive-stereo", synth::Sensor::kPassiveStereo},
                                                             {"tof", synth::Sensor::kTimeOfFlight},
                                                             {"ideal", synth::Sensor::kIdeal}};
  return kSensors;
}

}  // namespace

synth::Sensor SynthArguments::chosen_sensor() const { return sensors().at(sensor); }

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

}  // namespace segserve::segctl
