#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include "client/segctl/command.hpp"
#include "client/segctl/scene_output.hpp"
#include "client/segctl/staged_output.hpp"
#include "core/lab/synth/scene.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr const char* kFooter = R"(Examples:
  segctl synth -o table.pcd --picture truth.png
  segctl synth --seed 7 --objects 12 --noise 0 -o table.ply
  segctl synth --fused --points 1000000 -o room.pcd

The same flags give the same bytes on every machine. Ground truth is the field "label": 0 no
point, 1 to 9 table, floor and walls, 20, 30, 40, .. objects.

Exit codes: 0 done; 1 failed (disk full); 2 bad usage.)";

struct Arguments {
  synth::SceneOptions table;
  synth::RoomOptions room;
  std::uint64_t seed = 1;
  double noise = 1;
  CLI::Option* objects_given = nullptr;
  std::uint32_t objects = 0;
  bool fused = false;
  bool no_holes = false;
  SceneOutput scene_output;
  bool quiet = false;
};

void add_flags(CLI::App& app, Arguments& a) {
  const std::string table_group = "Table seen by a camera";
  const std::string room_group = "Room fused from many views";
  app.add_option("--seed", a.seed, "everything random follows from it")->capture_default_str();
  app.add_option("--noise", a.noise, "times the noise of a Kinect, 0 to 10")->capture_default_str();
  a.objects_given =
      app.add_option("--objects", a.objects,
                     fmt::format("number of objects; default {}, {} with --fused", a.table.objects, a.room.objects));
  CLI::Option* fused =
      app.add_flag("--fused", a.fused, "a room in one WORLD cloud, instead of a table")->group(room_group);
  const auto table_option = [&](const std::string& flag, auto& value, const std::string& help) {
    app.add_option(flag, value, help)->capture_default_str()->excludes(fused)->group(table_group);
  };
  const auto room_option = [&](const std::string& flag, auto& value, const std::string& help) {
    app.add_option(flag, value, help)->capture_default_str()->needs(fused)->group(room_group);
  };
  table_option("--width", a.table.width, "pixels, 16 to 4096");
  table_option("--height", a.table.height, "pixels, 16 to 4096");
  table_option("--stacked", a.table.stacked, "share of the objects on top of others, 0 to 1");
  table_option("--clutter", a.table.clutter, "0: objects spread over the table, 1: crowded");
  table_option("--distance", a.table.distance, "times the usual distance of the camera, 0.5 to 3");
  app.add_flag("--no-holes", a.no_holes, "no points without depth on the table")->excludes(fused)->group(table_group);
  app.add_flag("--all-finite", a.table.all_finite, "a wall behind the table: every pixel is a point")
      ->excludes(fused)
      ->group(table_group);
  room_option("--points", a.room.points, "1000 to 50 million");
  room_option("--size", a.room.size, "times the usual edge of the room, 0.5 to 10");
  a.scene_output.add_to(app, true);
  app.add_flag("-q,--quiet", a.quiet, "print no summary")->group("Output");
}

absl::StatusOr<synth::SyntheticScene> make_scene(const Arguments& arguments) {
  const bool objects_given = arguments.objects_given->count() > 0;
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

std::string describe(const synth::SyntheticScene& scene) {
  std::size_t finite = 0;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    finite += is_finite(scene.cloud.x[i], scene.cloud.y[i], scene.cloud.z[i]) ? 1U : 0U;
  }
  std::set<std::uint32_t> objects;
  for (const std::uint32_t label : scene.label) {
    if (label >= 20) objects.insert(label / 10);  // visible parts of an object differ in the last digit
  }
  return fmt::format("{} x {}: {} points, {} finite, {} objects\n", scene.cloud.width, scene.cloud.height,
                     scene.cloud.size(), finite, objects.size());
}

absl::Status run(const Arguments& arguments) {
  StagedOutput output;
  if (!arguments.scene_output.wanted()) return absl::InvalidArgumentError("-o or --picture is needed");
  if (absl::Status status = arguments.scene_output.announce(output); !status.ok()) return status;
  const auto scene = make_scene(arguments);
  if (!scene.ok()) return scene.status();
  arguments.scene_output.add(output, scene->cloud, scene->label);
  if (!arguments.quiet && !output.uses_stdout()) output.add("-", describe(*scene));
  return output.commit();
}

}  // namespace

void add_synth_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("synth", "Make a synthetic RGB-D scene with ground truth");
  auto arguments = std::make_shared<Arguments>();
  add_flags(*command, *arguments);
  command->footer(kFooter);
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace segserve::segctl
