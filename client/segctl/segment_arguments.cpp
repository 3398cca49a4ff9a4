// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/segment_arguments.hpp"

#include <filesystem>
#include <system_error>

#include "client/segctl/view_flag.hpp"
#include "core/base/status_macros.hpp"
#include "fmt/format.h"

namespace segserve::segctl {
namespace {

constexpr double kDefaultTimeout = 30;

}  // namespace

void SegmentArguments::add_to(CLI::App& app) {
  app.add_option(
         "SCENE", scenes,
         "file of a cloud (PCD, PLY, LAS, text, OBJ, NPY, NPZ; also .gz, .zst) or recording (MCAP, ROS 1 bag); - is "
         "standard input; with --out-dir several files or folders")
      ->type_name("FILE");
  options.add_to(app);
  app.add_option("--view", view,
                 "where the sensor is: camera, world, or world:X,Y,Z with its position in meters; "
                 "default: what the file says, or its points make plain")
      ->type_name("VIEW")
      ->group("Segmentation");
  unit.add_to(app, "Segmentation");
  rgbd.add_to(app);
  recording.add_to(app);
  recording.add_output_to(app);
  server.add_to(app, kDefaultTimeout);
  app.add_flag("--local", local, "segment in this process, without a server")->group("Server");
  app.add_flag("--fallback-local", fallback_local, "segment in this process if no server is in reach")->group("Server");
  codec.add_to(app,
               "pcd sends a PCD file as it is; default: planar, or planar-zstd if that would be too large "
               "for one call",
               "Server");
  app.add_option("--request-id", request_id, "name of this call in the server's logs")
      ->type_name("TEXT")
      ->group("Server");
  scene_output.add_to(app);
  split_output.add_to(app);
  app.add_option("--result", result_path, "save the result with its merge tree, for segctl cut")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("--segments", segments, "tell points, centroid, box, mean color and normal of every segment in JSON")
      ->group("Output");
  json.add_to(app, "write the summary as JSON: one object, or a line for each file or frame of many");
  CLI::Option* out_dir_flag = app.add_option("--out-dir", out_dir,
                                             "for many files: write DIR/NAME.pcd, labeled, and DIR/NAME.json of each, "
                                             "unless they are there and of the same options")
                                  ->type_name("DIR")
                                  ->group("Output");
  app.add_option("--parallel", parallel, "files at the same time; default 4, with --local one per CPU")
      ->check(CLI::Range(1, 256))
      ->needs(out_dir_flag)
      ->group("Output");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

absl::Status SegmentArguments::check_combination() const {
  const bool many = !out_dir.empty();
  if (many &&
      (scene_output.wanted() || split_output.wanted() || !result_path.empty() || !request_id.empty() || rgbd.given())) {
    return absl::InvalidArgumentError(
        "--out-dir excludes -o, --split, --picture, --plain-picture, --result, --request-id and RGB-D images");
  }
  if (!many && scenes.size() > 1) return absl::InvalidArgumentError("more than one SCENE needs --out-dir");
  if (std::error_code error; !many && !scenes.empty() && std::filesystem::is_directory(scenes.front(), error)) {
    return absl::InvalidArgumentError(fmt::format(
        "{} is a folder: --out-dir DIR segments all files in it and writes their labels to DIR", scenes.front()));
  }
  if (scenes.empty() && !rgbd.given()) {
    return absl::InvalidArgumentError("SCENE is required, or --depth and --intrinsics (see segctl segment --help)");
  }
  if (!scenes.empty() && rgbd.given()) {
    return absl::InvalidArgumentError("SCENE and RGB-D images exclude each other");
  }
  if (rgbd.given() && !view.empty()) {
    return absl::InvalidArgumentError("--view does not go with RGB-D images: they are seen from the camera");
  }
  if (rgbd.given() && unit.given()) {
    return absl::InvalidArgumentError("--unit does not go with RGB-D images: --depth-scale tells their unit");
  }
  if (segments && !json.given() && result_path.empty() && !many) {
    return absl::InvalidArgumentError("--segments needs --json, --result or --out-dir, which tell of them");
  }
  if (local && server.server_given()) {
    return absl::InvalidArgumentError("--local and --server exclude each other");
  }
  if (local && fallback_local) {
    return absl::InvalidArgumentError("--local and --fallback-local exclude each other: --local asks no server");
  }
  if (local && !request_id.empty()) {
    return absl::InvalidArgumentError("--request-id needs a server: not together with --local");
  }
  return absl::OkStatus();
}

absl::StatusOr<SegmentRequest> SegmentArguments::request() const {
  SegmentRequest request;
  ASSIGN_OR_RETURN(request.options, options.options());
  if (!view.empty()) {
    ASSIGN_OR_RETURN(request.view, parse_view(view));
  }
  ASSIGN_OR_RETURN(request.codec, codec.options());
  request.segments = segments;
  request.unit = unit.unit();
  request.keep_everything = scene_output.wanted() || split_output.wanted() || !out_dir.empty();
  return request;
}

}  // namespace segserve::segctl
