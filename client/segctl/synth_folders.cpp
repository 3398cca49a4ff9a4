// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/synth_folders.hpp"

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/segctl/camera_rig.hpp"
#include "client/segctl/output_folder.hpp"
#include "client/segctl/progress_bar.hpp"
#include "client/segctl/sequence.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "core/lab/synth/table_rig.hpp"
#include "fmt/format.h"
#include "nlohmann/json.hpp"

namespace segserve::segctl {
namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

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
                               arguments.scene_output.encode_pcd(content, view.scene.label).bytes));
    for (const std::uint32_t label : view.scene.label) {
      if (label >= kFirstObjectLabel) objects.insert(label);
    }
  }
  RETURN_IF_ERROR(write_file(arguments.rig_folder, kRigFile, rig_json(cameras)));
  return tell(arguments, Json{{"cameras", cameras.size()}, {"objects", objects.size()}, {"seed", arguments.seed}},
              fmt::format("{}: {} cameras, {} objects\n", arguments.rig_folder, cameras.size(), objects.size()));
}

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
                               arguments.scene_output.encode_pcd(content, frame.scene.label).bytes));
    bar.show(i + 1, scene.frames());
  }
  RETURN_IF_ERROR(write_file(arguments.moving_folder, kSequenceFile, sequence_json(frames)));
  return tell(arguments, Json{{"frames", frames.size()}, {"rate", options.rate}, {"moving", scene.moving()}},
              fmt::format("{}: {} frames, {} objects move\n", arguments.moving_folder, frames.size(), scene.moving()));
}

}  // namespace segserve::segctl
