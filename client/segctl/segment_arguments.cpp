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
  app.add_option("SCENE", scenes,
                 "file of a cloud (PCD, PLY, LAS, text, OBJ, NPY, NPZ, KITTI; also .gz, .zst) or recording (MCAP, ROS "
                 "1 bag); - is "
                 "standard input; with --out-dir several files or folders")
      ->type_name("FILE");
  app.add_option("--cameras", cameras,
                 "instead of SCENE: a JSON file that names the clouds of several cameras and their poses")
      ->type_name("FILE")
      ->group("Several cameras");
  options.add_to(app);
  prompts.add_to(app, false);
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
  trace.add_to(app);
  track.add_to(app, "follow the objects through a folder of clouds or a recording: labels are ids that they keep");
  scene_output.add_to(app);
  split_output.add_to(app);
  dendrogram.add_to(app);
  app.add_option("--result", result_path, "save the result with its merge tree, for segctl cut")
      ->type_name("FILE")
      ->group("Output");
  app.add_flag("--segments", segments, "tell points, centroid, box, mean color and normal of every segment in JSON")
      ->group("Output");
  json.add_to(app,
              "write the summary as JSON: one object, or a line for each file or frame of many, and a last one with "
              "warnings of a recording as a whole");
  CLI::Option* out_dir_flag = app.add_option("--out-dir", out_dir,
                                             "for many files: write DIR/NAME.pcd, labeled, and DIR/NAME.json of each, "
                                             "unless they are there and of the same options; with --cameras only "
                                             "DIR/NAME.pcd")
                                  ->type_name("DIR")
                                  ->group("Output");
  app.add_option("--contact-sheet", contact_sheet,
                 "for many files: write one picture with a small one of each, its name and how many segments it "
                 "has: PNG; - is standard output")
      ->type_name("FILE")
      ->group("Output");
  app.add_option("--parallel", parallel, "files at the same time; default 4, with --local one per CPU")
      ->check(CLI::Range(1, 256))
      ->needs(out_dir_flag)
      ->group("Output");
  app.add_flag("-q,--quiet", quiet, "print no summary")->group("Output");
}

absl::Status SegmentArguments::check_cameras() const {
  if (cameras.empty()) return absl::OkStatus();
  if (!scenes.empty() || rgbd.given()) {
    return absl::InvalidArgumentError("--cameras names the clouds itself: not together with SCENE or RGB-D images");
  }
  if (track.track || recording.given() || parallel != 0 || !contact_sheet.empty()) {
    return absl::InvalidArgumentError(
        "--cameras is for one frame: not together with --track, --topic, --parallel or --contact-sheet");
  }
  return absl::OkStatus();
}

absl::Status SegmentArguments::check_combination() const {
  RETURN_IF_ERROR(check_cameras());
  const bool many = this->many();
  if (many && prompts.given()) {
    return absl::InvalidArgumentError(
        "--include, --exclude, --larger and --smaller are for one cloud: not with --out-dir or --contact-sheet");
  }
  if (many && (scene_output.wanted() || split_output.wanted() || dendrogram.given() || !result_path.empty() ||
               !request_id.empty() || rgbd.given())) {
    return absl::InvalidArgumentError(
        "--out-dir and --contact-sheet exclude -o, --split, --picture, --plain-picture, --dendrogram, --result, "
        "--request-id and RGB-D images");
  }
  if (many || track.track) RETURN_IF_ERROR(scene_output.check_without_pictures());
  RETURN_IF_ERROR(scene_output.check_cloud_flags(split_output.wanted() || !out_dir.empty()));
  if (track.track && (!contact_sheet.empty() || dendrogram.given())) {
    return absl::InvalidArgumentError("--track excludes --contact-sheet and --dendrogram");
  }
  if (track.track && (scenes.size() != 1 || scenes.front() == "-" || rgbd.given())) {
    return absl::InvalidArgumentError("--track needs one folder of clouds, or one recording");
  }
  if (track.track && (parallel != 0 || scene_output.wants_picture() || split_output.wanted())) {
    return absl::InvalidArgumentError("--track excludes --parallel, --picture, --plain-picture and --split");
  }
  if (!many && scenes.size() > 1) return absl::InvalidArgumentError("more than one SCENE needs --out-dir");
  if (std::error_code error;
      !many && !track.track && !scenes.empty() && std::filesystem::is_directory(scenes.front(), error)) {
    return absl::InvalidArgumentError(fmt::format(
        "{} is a folder: --out-dir DIR segments all files in it and writes their labels to DIR", scenes.front()));
  }
  if (scenes.empty() && !rgbd.given() && cameras.empty()) {
    return absl::InvalidArgumentError(
        "SCENE is required, or --cameras, or --depth and --intrinsics (see segctl segment --help)");
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
  const bool writes_summaries = !out_dir.empty() && cameras.empty();
  if (segments && !json.given() && result_path.empty() && !writes_summaries) {
    return absl::InvalidArgumentError("--segments needs --json, --result or --out-dir, which tell of them");
  }
  if (local && server.server_given()) {
    return absl::InvalidArgumentError("--local and --server exclude each other");
  }
  if (const auto flag = server.connection_flag(); local && flag) {
    return absl::InvalidArgumentError(fmt::format("{} is for a server: not together with --local", *flag));
  }
  if (local && fallback_local) {
    return absl::InvalidArgumentError("--local and --fallback-local exclude each other: --local asks no server");
  }
  if (local && !request_id.empty()) {
    return absl::InvalidArgumentError("--request-id needs a server: not together with --local");
  }
  if (local && trace.given()) {
    return absl::InvalidArgumentError("--traceparent needs a server: not together with --local");
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
  if (prompts.given()) {
    ASSIGN_OR_RETURN(request.prompts, prompts.prompts());
  }
  request.unit = unit.unit();
  request.traceparent = trace.traceparent();
  request.keep_everything = scene_output.wanted() || split_output.wanted() || !out_dir.empty();
  return request;
}

}  // namespace segserve::segctl
