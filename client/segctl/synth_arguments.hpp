// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "client/segctl/json_flag.hpp"
#include "client/segctl/rgbd_output.hpp"
#include "client/segctl/scene_output.hpp"
#include "core/lab/synth/moving_tabletop.hpp"
#include "core/lab/synth/scene.hpp"

namespace segserve::segctl {

/// The flags of `segctl synth`. They must outlive the parsing of the command line.
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
  synth::Sensor chosen_sensor() const;

 private:
  void add_scene_flags(CLI::App& app);
  void add_moving_flags(CLI::App& app);
  void add_rig_flags(CLI::App& app);
};

/// Sets what the table and the room that a camera sees have in common.
template <typename CameraOptions>
CameraOptions with_camera(const SynthArguments& arguments, CameraOptions options) {
  options.seed = arguments.seed;
  options.noise = arguments.noise;
  options.objects = arguments.objects.value_or(options.objects);
  options.sensor = arguments.chosen_sensor();
  options.width = arguments.width;
  options.height = arguments.height;
  options.holes = !arguments.no_holes;
  return options;
}

}  // namespace segserve::segctl
