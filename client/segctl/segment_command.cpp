// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/calls/local.hpp"
#include "client/segctl/camera_rig.hpp"
#include "client/segctl/command.hpp"
#include "client/segctl/input_file.hpp"
#include "client/segctl/output_folder.hpp"
#include "client/segctl/output_kind.hpp"
#include "client/segctl/segment_arguments.hpp"
#include "client/segctl/segment_many.hpp"
#include "client/segctl/segment_recording.hpp"
#include "client/segctl/segment_sequence.hpp"
#include "client/segctl/staged_output.hpp"
#include "client/segctl/summary.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "fmt/format.h"
#include "proto/wire/codec_message.hpp"
#include "segserve/cameras.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/client/result_file.hpp"
#include "segserve/codec/cloud_file.hpp"
#include "segserve/segment.hpp"

namespace segserve::segctl {
namespace {

constexpr const char* kExamples =
    R"(segctl segment scene.pcd -o labeled.pcd --picture segments.png --legend --dendrogram tree.png
segctl segment scene.ply --view world:0,0,1.5 --server robot:50051 --json -
segctl segment --depth depth.png --rgb color.jpg --intrinsics 525,525,319.5,239.5 --picture segments.png
segctl segment scene.pcd --result scene.segres; segctl cut scene.segres --threshold 0.2
segctl segment scene.pcd --include 320,240 --exclude 100,400 -o object.ply --drop-unlabeled
segctl segment scans/ --out-dir labeled/; segctl segment --cameras rig/cameras.json --out-dir views/
segctl segment scans/ --contact-sheet sheet.png; segctl segment run.mcap --topic /points -o labeled.mcap
segctl segment moving/ --track --out-dir followed/ --json tracks.jsonl)";

constexpr const char* kDetails =
    R"(Labels are numbered 1, 2, 3 and so on by descending size of the segment. Points that are not finite, that the crop
box or the range leaves out, or that are removed with the support plane get label 0.

Without --view, the file and its points tell where the sensor is: points on the rays of a camera's pixels are seen by
the camera, points on the rings of a LiDAR from the origin, others from VIEWPOINT if a PCD file has one that is not
(0, 0, 0). The summary says what was taken, and why. Images are seen by the camera; their depth is in
millimeters if it has integers, and in meters if it has floats, unless --depth-unit or --depth-scale says otherwise.

Coordinates far from the origin, such as UTM, are moved near it before they become floats. Outputs, centroids and boxes
are in the file's coordinates and unit again; all lengths on the command line are in meters.

Lossy codecs move points by at most their error bound. The labels still come back in the order of the input. With
--local and a codec, the points are segmented as a server would see them.

--include and --exclude pick an object, as segctl pick does: the fewest nodes of the merge tree that hold all included
places and no excluded one. A place is a position X,Y,Z in the coordinates and unit of the cloud's file, or a pixel U,V
of an image. Outputs then have the label 1 for what was picked, and 0 for the rest; --result saves the whole result.

Pictures show an organized cloud as its image. Other clouds are seen from their sensor, or obliquely from above if it is
amid them or not known; --view-from chooses another place. Segments that touch in the picture never look alike.

--dendrogram draws the merge tree: the heights of merges, and the cut as a dashed line. Gray branches hold several
segments. Merges that are too low, or too many, to be drawn one by one are left out; the colors below the tree tell
where they belong.

--contact-sheet draws up to 1000 files. It needs no --out-dir; with one, files that were done before are drawn, too.

--split writes as --encoding and --color say. Label 0 has no file. Files that another result left in DIR are removed.

From a recording the clouds or depth images of one topic are taken. The recording that -o writes has the clouds with the
field "label", those of images on the new topic TOPIC/labeled, and everything else as it was. A frame that fails stays
without labels. With --out-dir, every frame becomes a PCD file.

--cameras makes one cloud of those of several cameras, so that an object that several of them see is one segment. Its
file is {"cameras": [{"file": "left.pcd", "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "translation": [0, 0, 0.5]}, ...]}:
for each camera a file, relative to the folder of the JSON, and the rotation, row by row, and translation in meters
that lead from the coordinates of that file to a frame that all cameras share. -o and --picture write the whole cloud
in the shared frame, --out-dir the labeled cloud of each camera in its own. segctl synth --rig makes such a folder.

With --track, objects keep their ids from frame to frame: the labels that are written are ids, and the JSON tells for
each segment its id, and what became of the objects. The server remembers nothing, so that any of several may segment
any frame. docs/tracking.md describes it.

With --out-dir, files of one name are told apart: NAME.ply beside NAME.pcd goes to NAME.ply.pcd, and files of one name
in two folders go to folders of their names. A file that fails stops no other; errors are listed at the end, one a line.
The exit code is then 2 if every file that failed was bad input, else 1. Ctrl-C stops the rest, and so do servers that
are all out of reach for 10 s (or half of --timeout, if that is less). The same command goes on from there.)";

constexpr const char* kExitCodes =
    "0 success; 1 the operation failed (no server, time over, disk full); 2 bad input or usage; 130 Ctrl-C.";

HelpText help() {
  return {.common = {"--method", "--threshold", "--regions", "--include", "--exclude", "--view", "--depth", "--rgb",
                     "--intrinsics", "--server", "--local", "--output", "--picture", "--result", "--segments", "--json",
                     "--out-dir", "--topic"},
          .examples = kExamples,
          .details = kDetails,
          .exit_codes = kExitCodes};
}

absl::Status announce_outputs(const SegmentArguments& arguments, StagedOutput& output) {
  RETURN_IF_ERROR(arguments.scene_output.announce(output));
  RETURN_IF_ERROR(arguments.split_output.announce(output));
  RETURN_IF_ERROR(arguments.dendrogram.announce(output));
  if (!arguments.result_path.empty()) {
    RETURN_IF_ERROR(output.announce(arguments.result_path));
    RETURN_IF_ERROR(check_output_name("--result", arguments.result_path, OutputKind::kResult));
  }
  return arguments.json.announce(output);
}

/// One cloud on its way to be segmented.
struct Job {
  std::string input;                         ///< The name of the input in messages.
  std::optional<std::string> file_bytes;     ///< Of a cloud; unset for images.
  std::optional<client::Payload> payload;    ///< A PCD file or images that are sent without decoding them here.
  std::optional<codec::LabeledCloud> scene;  ///< Unset if only the server needs the points.
  std::optional<RigScene> rig;               ///< Of several cameras, but for the merged cloud, which is the scene.
  SegmentRequest request;
};

absl::StatusOr<codec::LabeledCloud> decode(const SegmentArguments& arguments, const Job& job) {
  auto scene = job.file_bytes
                   ? codec::decode_cloud(std::as_bytes(std::span(*job.file_bytes)), {}, job.request.read_options())
                   : client::decode(*job.payload);
  if (scene.ok()) return scene;
  if (arguments.rgbd.given()) return arguments.rgbd.with_file_name(scene.status());
  return with_prefix(job.input, scene.status());
}

/// Where the labeled cloud of a camera goes.
std::string path_of_camera(const SegmentArguments& arguments, const std::string& file) {
  const std::filesystem::path name = std::filesystem::path(file).stem().string() + ".pcd";
  return (std::filesystem::path(arguments.out_dir) / name).string();
}

/// INVALID_ARGUMENT if the cloud of a camera would be overwritten.
absl::Status check_paths_of_cameras(const SegmentArguments& arguments, const RigScene& rig) {
  for (const std::string& file : rig.files) {
    if (std::error_code error; std::filesystem::equivalent(file, path_of_camera(arguments, file), error)) {
      return absl::InvalidArgumentError(
          fmt::format("{} would be overwritten by its own output: use another folder for --out-dir", file));
    }
  }
  return absl::OkStatus();
}

absl::Status read_files(const SegmentArguments& arguments, Job& job) {
  if (!arguments.cameras.empty()) {
    job.input = arguments.cameras;
    ASSIGN_OR_RETURN(job.rig, read_rig(arguments.cameras, job.request.read_options()));
    job.scene = std::move(job.rig->merged);
    return arguments.out_dir.empty() ? absl::OkStatus() : check_paths_of_cameras(arguments, *job.rig);
  }
  if (arguments.rgbd.given()) {
    job.input = arguments.rgbd.input_name();
    ASSIGN_OR_RETURN(auto images, arguments.rgbd.load());
    job.payload = client::rgbd_payload(std::move(images));
    return absl::OkStatus();
  }
  job.input = input_name(arguments.scenes.front());
  ASSIGN_OR_RETURN(std::string bytes, read_input(arguments.scenes.front()));
  const bool sends_pcd = job.request.codec && job.request.codec->codec == wire::Codec::kPcd;
  job.file_bytes = std::move(bytes);
  if (sends_pcd && codec::is_taken_as_pcd(std::as_bytes(std::span(*job.file_bytes)))) {
    job.payload = client::pcd_payload(*job.file_bytes, job.request.view, job.request.unit);
  }
  return absl::OkStatus();
}

absl::StatusOr<Job> prepare(const SegmentArguments& arguments) {
  Job job;
  ASSIGN_OR_RETURN(job.request, arguments.request());
  if (job.request.codec && arguments.rgbd.given()) {
    return absl::InvalidArgumentError("--codec, --error-bound and --zstd do not go with RGB-D images");
  }
  RETURN_IF_ERROR(arguments.server.timeout().status());
  RETURN_IF_ERROR(read_files(arguments, job));
  return job;
}

absl::StatusOr<client::Result> segment_remotely(const SegmentArguments& arguments, Job& job) {
  ASSIGN_OR_RETURN(const auto client, arguments.server.connect(arguments.fallback_local));
  client::CallOptions call;
  call.request_id = arguments.request_id;
  call.traceparent = job.request.traceparent;
  call.codec = job.request.codec;
  call.outputs.segments = job.request.segments || job.request.prompts;
  call.prompts = job.request.prompts;
  if (call.prompts && !job.payload) call.prompts = codec::to_cloud(job.scene->placement, *call.prompts);
  call.outputs.compression = answer_compression(job.request.codec);
  auto result =
      job.payload ? client.segment_payload(*job.payload, job.request.options, call)
                  : client.segment(job.scene->cloud, codec::to_cloud(job.scene->placement, job.request.options), call);
  if (!result.ok() && arguments.rgbd.given()) return arguments.rgbd.with_file_name(or_locally(result.status()));
  if (!result.ok()) return or_locally(result.status());
  if (!job.payload) take_file_facts(*job.scene, *result);
  if (job.request.prompts && !result->selection) {
    return absl::UnimplementedError("the server is too old for --include: it answered without a selection");
  }
  return result;
}

absl::StatusOr<client::Result> segment_here(const SegmentArguments& arguments, const Job& job) {
  std::optional<StopToken::Clock::time_point> deadline;
  if (arguments.server.timeout_given()) deadline = StopToken::Clock::now() + *arguments.server.timeout();
  const StopToken stop(nullptr, deadline);
  const auto segment = [&](const Cloud& cloud) -> absl::StatusOr<client::Result> {
    const Options options = codec::to_cloud(job.scene->placement, job.request.options);
    const wire::Outputs outputs{.segments = job.request.segments || job.request.prompts};
    std::optional<Prompts> prompts = job.request.prompts;
    if (prompts) prompts = codec::to_cloud(job.scene->placement, *prompts);
    ASSIGN_OR_RETURN(auto result, client::segment_here(cloud, job.scene->view_rule, options, outputs, stop, prompts));
    take_file_facts(*job.scene, result);
    return result;
  };
  if (!job.request.codec || job.payload) return segment(job.scene->cloud);
  // The points as a server would see them.
  ASSIGN_OR_RETURN(const auto payload, client::cloud_payload(job.scene->cloud, *job.request.codec));
  ASSIGN_OR_RETURN(const auto decoded, client::decode(payload));
  return segment(decoded.cloud);
}

/// Adds the labeled cloud of each camera.
absl::Status add_clouds_of_cameras(const SegmentArguments& arguments, const Job& job, const client::Result& result,
                                   StagedOutput& output, std::vector<codec::Warning>& warnings) {
  const std::vector<std::uint32_t>& labels = result.selection ? result.selection->labels : result.segmentation.labels;
  ASSIGN_OR_RETURN(const auto parts, split_by_camera(job.scene->cloud.view, labels));
  RETURN_IF_ERROR(make_folder(arguments.out_dir));
  for (std::size_t c = 0; c < parts.size(); ++c) {
    const std::string path = path_of_camera(arguments, job.rig->files[c]);
    RETURN_IF_ERROR(output.announce(path));
    codec::EncodedFile file = arguments.scene_output.encode_pcd(job.rig->of_camera[c], parts[c]);
    append_warnings(path, file.warnings, warnings);
    output.add(path, std::move(file.bytes));
  }
  return absl::OkStatus();
}

absl::Status write_outputs(const SegmentArguments& arguments, Job& job, client::Result& result, double call_ms,
                           StagedOutput& output) {
  std::vector<codec::Warning> of_output;
  if (arguments.scene_output.wanted() || arguments.split_output.wanted()) {
    const std::vector<std::uint32_t>& labels = result.selection ? result.selection->labels : result.segmentation.labels;
    RETURN_IF_ERROR(arguments.scene_output.add(output, *job.scene, labels, of_output));
    RETURN_IF_ERROR(arguments.split_output.add(output, *job.scene, labels, arguments.scene_output, of_output));
  }
  if (job.rig && !arguments.out_dir.empty()) {
    RETURN_IF_ERROR(add_clouds_of_cameras(arguments, job, result, output, of_output));
  }
  if (arguments.dendrogram.given()) {
    RETURN_IF_ERROR(arguments.dendrogram.add(output, result, &*job.scene, arguments.scene_output));
  }
  if (!arguments.result_path.empty()) {
    ASSIGN_OR_RETURN(auto bytes, client::encode_result_file(result, client::fingerprint(job.scene->cloud)));
    output.add(arguments.result_path, std::move(bytes));
  }
  // A saved result is without these: it may be written in another format.
  result.warnings.insert(result.warnings.end(), of_output.begin(), of_output.end());
  Summary summary{.result = result,
                  .input = job.input,
                  .server = result.in_this_process ? "" : arguments.server.address(),
                  .timings = stage_timings(result),
                  .with_segments = job.request.segments,
                  .prompts = job.request.prompts};
  if (!arguments.local) summary.timings.push_back({"round_trip", call_ms});
  return report(summary, arguments.json, arguments.quiet, output);
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

absl::Status segment_one(const SegmentArguments& arguments) {
  StagedOutput output;
  RETURN_IF_ERROR(output.protect(arguments.scenes));
  RETURN_IF_ERROR(output.protect(arguments.rgbd.paths(), true));
  if (!arguments.cameras.empty()) RETURN_IF_ERROR(output.protect({arguments.cameras}, true));
  RETURN_IF_ERROR(announce_outputs(arguments, output));
  ASSIGN_OR_RETURN(Job job, prepare(arguments));
  if (job.rig) RETURN_IF_ERROR(output.protect(job.rig->files, true));

  auto start = std::chrono::steady_clock::now();
  const bool needs_points = arguments.scene_output.wanted() || arguments.split_output.wanted() ||
                            arguments.dendrogram.given() || !arguments.result_path.empty();
  if (!job.scene && (arguments.local || !job.payload || needs_points)) {
    ASSIGN_OR_RETURN(job.scene, decode(arguments, job));
  }
  const double decode_ms = milliseconds_since(start);

  start = std::chrono::steady_clock::now();
  ASSIGN_OR_RETURN(auto result, arguments.local ? segment_here(arguments, job) : segment_remotely(arguments, job));
  const double call_ms = milliseconds_since(start);
  if (result.in_this_process && !arguments.local) warn_of_fallback(arguments.server.address());
  if (arguments.local) {
    result.timings.decode = decode_ms;
    result.timings.total += decode_ms;
  }
  return write_outputs(arguments, job, result, call_ms, output);
}

absl::Status run(const SegmentArguments& arguments) {
  RETURN_IF_ERROR(arguments.check_combination());
  arguments.trace.announce();
  if (!arguments.cameras.empty()) return segment_one(arguments);
  if (arguments.scenes.size() == 1 && is_recording_file(arguments.scenes.front())) {
    if (arguments.prompts.given())
      return absl::InvalidArgumentError("--include and --exclude are for one cloud, not for a recording");
    return segment_recording(arguments);
  }
  if (arguments.recording.given()) {
    return absl::InvalidArgumentError(
        "--topic, --color-topic, --camera-info-topic and --only-topic are for one recording (MCAP or ROS 1 bag)");
  }
  if (arguments.track.track) {
    if (std::error_code error; !std::filesystem::is_directory(arguments.scenes.front(), error)) {
      return absl::InvalidArgumentError("--track needs a folder of clouds, or a recording (MCAP or ROS 1 bag)");
    }
    if (arguments.scene_output.wanted()) {
      return absl::InvalidArgumentError("--track writes the clouds of a folder with --out-dir, not with -o");
    }
    return segment_sequence(arguments);
  }
  return arguments.many() ? segment_many(arguments) : segment_one(arguments);
}

}  // namespace

void add_segment_command(CLI::App& app, Command& chosen) {
  add_command(app, chosen, "segment", "Segment a colored point cloud: one label for every point", help(), run);
}

}  // namespace segserve::segctl
